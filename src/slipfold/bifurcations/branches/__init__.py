"""Branches of orbits: how they start, their bifurcations, ends and switching."""
