"""A result in one file of netCDF 3, which most programs read."""

import xarray as xr

from worker.errors import InvalidJob

NETCDF = "application/x-netcdf"
"""Media type of the file."""
MOST_BYTES = 200_000_000
"""Of a result that becomes one file: a basin of 2000 x 2000 cells has 184 million."""


def netcdf_of(dataset: xr.Dataset, zarr: str) -> bytes:
    """Write a result as netCDF.

    Parameters
    ----------
    dataset : xarray.Dataset
    zarr : str
        Where the store itself can be read.

    Returns
    -------
    bytes

    Raises
    ------
    InvalidJob
        If it is too large for one file in memory.

    Examples
    --------
    >>> import rattle
    >>> netcdf_of(rattle.basin(cells=40, progress=False), "here")[:3]
    b'CDF'
    """
    if dataset.nbytes > MOST_BYTES:
        raise InvalidJob(
            f"the result has {dataset.nbytes / 1e6:.0f} MB, more than the {MOST_BYTES / 1e6:.0f} MB of one netCDF file "
            f"here: read the Zarr store at {zarr}, and write what you need with to_netcdf"
        )
    return bytes(dataset.to_netcdf())
