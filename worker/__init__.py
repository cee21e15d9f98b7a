"""Basins as distributed work: jobs, tiles, Zarr stores, the Dask driver, assembly, pictures.

The only package that speaks to Dask and Zarr; it knows nothing of HTTP or databases.
"""
