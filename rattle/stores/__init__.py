"""What is done with whole stores: they are checked, and taken away."""
