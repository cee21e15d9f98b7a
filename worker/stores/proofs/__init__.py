"""A proof in a store: its variables and how they are written and read."""
