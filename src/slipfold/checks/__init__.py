"""Results held against their equations by other means than those that found them."""
