"""Results of studies."""
