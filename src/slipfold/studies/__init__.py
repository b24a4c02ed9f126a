"""Many cases of one computation: what they are, where they run, and that none is lost."""
