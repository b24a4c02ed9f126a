"""Branches at other parameter values: all their points at once, without following them again."""
