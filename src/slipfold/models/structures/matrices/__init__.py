"""Matrices of a structure: where they come from, damping, reduction."""
