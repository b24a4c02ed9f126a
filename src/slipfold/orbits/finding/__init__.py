"""First orbits: cycles, forced responses, stiff ones."""
