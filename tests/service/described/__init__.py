"""What the service says of itself, and whether it does so."""
