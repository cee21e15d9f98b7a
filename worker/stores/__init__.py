"""Zarr stores: layout, tiles, reading and writing; nothing of Dask."""
