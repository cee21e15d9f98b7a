"""Uncertainty exponent: how slowly better knowledge of the initial condition makes the final motion certain.

A cell is *uncertain* at distance e if any of the four cells e away, along time or velocity, ends in a different motion.
The share of such cells scales as

    f(e) ~ e^alpha,    alpha = 2 - d

where d is the box dimension of the boundary in the plane. A smooth boundary has alpha = 1: knowing the initial
condition ten times better makes ten times fewer cells uncertain. A fractal boundary has alpha < 1.

A picture shows alpha at the scale of its cells. Infinitely many stripes that thin out towards a curve, f ~ e ln(1/e),
look fractal in any one picture, though their alpha tends to 1. So compare grids before calling a boundary fractal.

Grebogi, McDonald, Ott and Yorke, Final state sensitivity: an obstruction to predictability, Phys. Lett. A 99, 415
(1983); McDonald, Grebogi, Ott and Yorke, Fractal basin boundaries, Physica D 17, 125 (1985).
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle_kernels.basin_measures.arrays import check_basins
from rattle_kernels.numerics.jit import kernel

_DISTANCES = (1, 2, 3, 4, 6, 8, 12, 16)


class UncertaintyExponent(NamedTuple):
    """Slope alpha of ln f over ln e with its standard error, and the data fitted.

    ``distance`` (int64) holds the distances e in cells, ``uncertain_share`` (float64) the shares f(e) of uncertain
    cells. Exponent and error are NaN if fewer than three shares are positive: there is hardly any boundary, or none.
    """

    exponent: float
    error: float
    distance: np.ndarray
    uncertain_share: np.ndarray

    @property
    def boundary_dimension(self) -> float:
        """Box dimension ``d = 2 - alpha`` of the boundary."""
        return 2.0 - self.exponent


@kernel
def _count_uncertain(solution, distance, margin, wraps):
    """Number of uncertain cells at least `margin` cells away from every edge of the window."""
    rows, columns = solution.shape
    side = 0 if wraps else margin
    count = 0
    for i in range(margin, rows - margin):
        for j in range(side, columns - side):
            here = solution[i, j]
            # These leave the row only if time wraps.
            left = j - distance if j >= distance else j - distance + columns
            right = j + distance if j + distance < columns else j + distance - columns
            same = solution[i, left] == here and solution[i, right] == here
            same = same and solution[i - distance, j] == here and solution[i + distance, j] == here
            count += 0 if same else 1
    return count


def _fit(distance: np.ndarray, count: np.ndarray, cells: int) -> tuple[float, float]:
    """Slope of ln(count) over ln(distance) and its standard error, by weighted least squares.

    The logarithm of a share f of n cells has variance (1 - f)/(f n). The weight is its inverse, with one cell added to
    both sides so that no weight is infinite. Neighbouring cells are not independent draws, so the error comes from the
    scatter of the residuals about the line, not from n.
    """
    x, y = np.log(distance), np.log(count / cells)
    weight = (count + 1.0) / (cells - count + 1.0)
    x = x - np.average(x, weights=weight)
    spread = (weight * x * x).sum()
    slope = (weight * x * y).sum() / spread
    residual = y - np.average(y, weights=weight) - slope * x
    variance = (weight * residual**2).sum() / (x.size - 2)
    return float(slope), math.sqrt(variance / spread)


def uncertainty_exponent(
    solution: np.typing.ArrayLike, distances: Sequence[int] = _DISTANCES, *, wraps: bool = False
) -> UncertaintyExponent:
    """Uncertainty exponent alpha of the boundaries between all motions of a picture.

    Parameters
    ----------
    solution : array_like of int, shape (velocity cells, time cells)
        Index of the motion that each cell ends in; none negative. Pass ``solution == index`` for the boundary of a
        single basin.
    distances : sequence of int
        Distances e in cells, at least three different ones. The same cells are counted for all: those with every
        neighbour in the window.
    wraps : bool
        Whether the window spans a whole period (`CellGrid.wraps`), so that its last column is next to its first.

    Returns
    -------
    UncertaintyExponent

    Raises
    ------
    ValueError
        If a cell has no solution, or the distances do not fit into the window.

    Notes
    -----
    ``f(e) ~ e^alpha`` (Grebogi et al., 1983), fitted as ``ln f = alpha ln e + c`` with weights ``f/(1 - f)``. The error
    is that of the straight line: it shows how well a power law fits, not what a finer grid would give.
    """
    array = check_basins(solution)
    distance = np.unique(np.asarray(distances, np.int64))
    longest = (min(array.shape) - 1) // 2
    if distance.size < 3 or distance[0] < 1 or distance[-1] > longest:
        raise ValueError(f"distances must be three or more between 1 and {longest} cells, not {list(distances)}")
    margin = int(distance[-1])
    count = np.array([_count_uncertain(array, int(cells), margin, bool(wraps)) for cells in distance])
    counted = (array.shape[0] - 2 * margin) * (array.shape[1] - (0 if wraps else 2 * margin))
    seen = count > 0
    fit = _fit(distance[seen], count[seen], counted) if seen.sum() >= 3 else (math.nan, math.nan)
    return UncertaintyExponent(*fit, distance, count / counted)
