"""What a client sees: results of the package as plain data for JSON."""
