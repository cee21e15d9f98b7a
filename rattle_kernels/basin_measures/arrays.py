"""What the measures of a basin picture take: an array of solutions, one for each cell."""

import numpy as np


def check_basins(solution: np.typing.ArrayLike) -> np.ndarray:
    """Return solutions as a contiguous array of int64, or say what is wrong with them.

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
        Where it is no plane of integers, or a cell has no solution (negative: missing, or followed to nowhere).
    """
    array = np.asarray(solution)
    if array.ndim != 2 or array.size == 0 or array.dtype.kind not in "iub":
        raise ValueError(f"solutions must be integers on a plane of cells, not {array.dtype} of shape {array.shape}")
    if array.min() < 0:
        raise ValueError(f"{int((array < 0).sum())} of {array.size} cells have no solution (negative): leave them out")
    return np.ascontiguousarray(array, np.int64)
