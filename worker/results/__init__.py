"""A store as xarray, its measures, and the data of a viewer."""
