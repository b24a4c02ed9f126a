"""Results compared with their equations by other means than those that computed them."""
