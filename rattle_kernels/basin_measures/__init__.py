"""Measures of a drawn basin."""
