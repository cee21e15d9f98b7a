"""Stores as several versions of Zarr write them, an archive each: `python -m tests.worker.zarr_stores.write`."""
