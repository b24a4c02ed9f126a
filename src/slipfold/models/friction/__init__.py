"""Friction laws, and the contact of a model in which one acts."""
