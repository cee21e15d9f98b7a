"""What is damaged or missing in a store, and how it is taken back so that it is computed anew."""
