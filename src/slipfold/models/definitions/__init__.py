"""What defines a system of equations: entries of files and tables, read, checked and written."""
