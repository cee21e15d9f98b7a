"""What a job says of a proof: what is asked for, and the lattice that it takes."""
