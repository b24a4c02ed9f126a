"""Measured responses: data, the orbits that explain them, fits, and what a test stand would see."""
