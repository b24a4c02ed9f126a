"""Integration: compiled flows, derivatives, batches, stick-slip events, simulation."""
