"""Results that are of one motion."""
