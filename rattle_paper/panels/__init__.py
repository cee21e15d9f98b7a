"""The panels of figures, and the data they show."""
