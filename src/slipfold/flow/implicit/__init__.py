"""Implicit steps, for motions in which what decays is much faster than what happens."""
