"""Zarr stores: layout, tiles, reading and writing, without Dask.

Floors, the highest first; each imports from lower ones alone ::

    checking
    analysis_store | basin_store | changes
    solution_arrays
    tile_arrays
    new_store | open_arrays | opening
    provenance | pyramid
    solution_table | table
    layout
"""
