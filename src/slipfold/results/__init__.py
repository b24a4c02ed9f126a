"""Results: labelled, saved and read back, printed and exported."""
