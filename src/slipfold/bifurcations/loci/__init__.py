"""Loci: bifurcations followed in two parameters, and all of them in a window of a plane."""
