"""Stores as several versions of Zarr write them, an archive each: `python -m tests.worker.stores.zarr_stores.write`."""
