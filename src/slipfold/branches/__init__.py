"""Continuation: stepping, test functions, location, normal forms, switching."""
