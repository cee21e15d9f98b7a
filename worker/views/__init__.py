"""A store as xarray, its measures, and what a viewer draws."""
