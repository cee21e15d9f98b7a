"""What is done with whole stores: they are checked, verified, exported and taken away."""
