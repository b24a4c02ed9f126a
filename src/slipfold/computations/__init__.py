"""What people call to compute: input checked, computed, checked again, made a result."""
