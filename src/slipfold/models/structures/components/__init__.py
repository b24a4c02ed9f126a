"""What acts on a structure: springs, contacts, forces, and where they act."""
