"""Measures of basins, from their pictures."""
