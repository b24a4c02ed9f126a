"""Figures of thresholds where parameters scatter, and where they are chosen."""
