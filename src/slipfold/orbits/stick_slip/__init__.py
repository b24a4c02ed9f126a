"""Orbits through stick and slip."""
