"""Time: compiled flows, their derivatives, batches of them, and simulation."""
