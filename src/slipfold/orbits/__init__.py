"""Orbits, cycles and equilibria: their equations, how perturbations grow, extrema."""
