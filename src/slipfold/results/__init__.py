"""Results: labeled, saved and read back, printed and exported."""
