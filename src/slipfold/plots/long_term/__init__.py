"""Figures of what motions do in the long run."""
