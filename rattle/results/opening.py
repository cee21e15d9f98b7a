"""Results as xarray datasets, wherever they lie."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr


def open(location: str | Path, *, key: str | None = None, level: int = 0) -> "xr.Dataset":
    """Open a result, complete or not.

    Parameters
    ----------
    location : str or path
        A folder, ``s3://bucket/prefix``, or a service's address that ends in ``result.zarr``.
    key : str, optional
        Of a service that requires one.
    level : int
        Of a basin with more than 4,000 cells a side: level n has every 2**n-th cell each way, with its own labels, so
        that the last level shows the whole basin at once. ``.rattle.levels`` lists them; 0 is the basin itself.

    Returns
    -------
    xarray.Dataset
        Read lazily. Its accessor ``.rattle`` draws and measures it.

    Raises
    ------
    InvalidJob
        If there is no such level.
    StoreConflict
        If there is no result.
    StoreFailed
        If a folder or S3 cannot be read.
    OSError
        If an address does not answer, or refuses; it then says whether a key is needed.

    Examples
    --------
    >>> import rattle
    >>> basin = rattle.basin(cells=20, store="basin.zarr", progress=False)
    >>> rattle.open("basin.zarr").name.values.tolist()
    ['permanent contact', 'P(1,1,0)', 'chaotic']
    """
    import rattle.results.accessor  # noqa: F401 - gives datasets their `.rattle`
    from worker.results.opening import open_level

    options: dict[str, Any] = {"headers": {"authorization": f"Bearer {key}"}} if key else {}
    return open_level(location, level, options)
