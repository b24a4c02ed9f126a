"""Structures from matrices, with elements, friction contacts and forcing."""
