"""Sets of models whose contacts may stick: where they begin to, and what motions do beyond."""
