"""How values read: one line each, tables for terminals and notebooks."""
