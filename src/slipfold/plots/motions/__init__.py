"""Many motions in one picture."""
