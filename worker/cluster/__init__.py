"""The Dask cluster and the driver of its tasks, whatever they compute."""
