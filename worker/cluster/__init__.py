"""The Dask cluster and the driver of its tasks; nothing of basins."""
