"""What thresholds do where parameters scatter, and where they are chosen."""
