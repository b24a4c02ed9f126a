"""Results about measured responses."""
