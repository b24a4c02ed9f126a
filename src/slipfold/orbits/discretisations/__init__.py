"""How orbits become equations: shooting, collocation, and of equilibria the vector field itself."""
