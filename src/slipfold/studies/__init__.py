"""Many cases of one computation: their plan, where they run, and how they are stored."""
