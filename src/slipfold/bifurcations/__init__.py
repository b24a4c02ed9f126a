"""Branches of solutions, loci of their bifurcations in two parameters, and tori."""
