"""What parameters do to thresholds: maps, uncertainty, design, and fits to measured data."""
