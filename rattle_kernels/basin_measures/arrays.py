"""The input of measures of a basin picture: an array with the solution of each cell."""

import numpy as np


def check_basins(solution: np.typing.ArrayLike) -> np.ndarray:
    """Return solutions as a contiguous array of int64, or raise if they are not valid.

    Parameters
    ----------
    solution : array_like of int or bool, shape (velocity cells, time cells)
        Index of the motion that each cell ends in.

    Returns
    -------
    ndarray of int64, that shape

    Raises
    ------
    ValueError
        If it is not a plane of integers, or a cell has no solution (negative: missing or unassigned).
    """
    array = np.asarray(solution)
    if array.ndim != 2 or array.size == 0 or array.dtype.kind not in "iub":
        raise ValueError(f"solutions must be integers on a plane of cells, not {array.dtype} of shape {array.shape}")
    if array.min() < 0:
        raise ValueError(f"{int((array < 0).sum())} of {array.size} cells have no solution (negative): leave them out")
    return np.ascontiguousarray(array, np.int64)
