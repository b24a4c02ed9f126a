"""What a study computes of every case: one kind of computation a file."""
