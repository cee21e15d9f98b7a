"""Least squares of some dozens of unknowns, by Householder's reflections, in the thread that asks.

LAPACK shares such a system among threads of BLAS, which wait for one another at each of its columns. Where several
threads fit at a time, or cores are busy, that took up to a hundred times as long as the fit itself.
"""

import math

import numpy as np

from rattle_kernels.numerics.jit import kernel


@kernel
def _solve(rows, solution):
    """Turn equations, with their right sides as last column, into a triangle in place, and solve it."""
    unknowns = solution.size
    reflected = np.empty(unknowns + 1)
    for k in range(unknowns):
        square = 0.0
        for i in range(k, rows.shape[0]):
            square += rows[i, k] * rows[i, k]
        diagonal = -math.copysign(math.sqrt(square), rows[k, k])
        rows[k, k] -= diagonal
        factor = -1.0 / (diagonal * rows[k, k])
        # By rows, which are short and lie in one piece.
        reflected[:] = 0.0
        for i in range(k, rows.shape[0]):
            for j in range(k + 1, unknowns + 1):
                reflected[j] += rows[i, k] * rows[i, j]
        for i in range(k, rows.shape[0]):
            share = factor * rows[i, k]
            for j in range(k + 1, unknowns + 1):
                rows[i, j] -= share * reflected[j]
        rows[k, k] = diagonal
    for k in range(unknowns - 1, -1, -1):
        left = rows[k, unknowns]
        for j in range(k + 1, unknowns):
            left -= rows[k, j] * solution[j]
        solution[k] = left / rows[k, k]


def least_squares(system: np.ndarray, goal: np.ndarray, least: float) -> np.ndarray:
    """Coefficients with which columns of a system add up most nearly to a goal.

    Parameters
    ----------
    system : ndarray of float64, shape (equations, unknowns)
    goal : ndarray of float64, shape (equations,)
    least : float
        Above 0. Of columns scaled to length 1, combinations shorter than this are left out, as good as.

    Returns
    -------
    ndarray of float64, shape (unknowns,)
    """
    equations, unknowns = system.shape
    scale = np.linalg.norm(system, axis=0)
    scale[scale == 0.0] = 1.0
    rows = np.zeros((equations + unknowns, unknowns + 1))
    rows[:equations, :-1], rows[:equations, -1] = system / scale, goal
    # An equation more for each coefficient holds at 0 what the others do not determine.
    rows[equations:, :-1] = least * np.eye(unknowns)
    solution = np.empty(unknowns)
    _solve(rows, solution)
    scaled: np.ndarray = solution / scale
    return scaled
