"""Quasi-periodic tori: invariant circles of the stroboscopic map, which bifurcate at NS points."""
