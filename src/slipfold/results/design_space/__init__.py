"""Results about thresholds where parameters scatter, and where they are chosen."""
