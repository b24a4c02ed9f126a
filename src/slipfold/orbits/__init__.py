"""Orbits, cycles and equilibria: equations, multipliers, extrema, limits, normal forms."""
