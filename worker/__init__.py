"""Basins as distributed work: jobs, tiles, Zarr stores, the Dask driver, assembly, pictures.

The only package that speaks to Dask and Zarr; it knows nothing of HTTP or databases.

Floors, the highest first; each imports from lower ones alone ::

    analyses
    results
    pictures | basins
    run
    stores | cluster
    machine_series
    estimate | gear_pair | kinds
    jobs | storage
    fence | motion_words | precision_limits | progress | rounding
    additions | errors
"""
