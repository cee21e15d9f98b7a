"""Zarr stores: layout, tiles, reading and writing, without Dask."""
