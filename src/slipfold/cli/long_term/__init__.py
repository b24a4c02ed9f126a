"""Commands about what motions do in the long run."""
