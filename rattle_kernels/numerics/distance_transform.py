"""Distance from every cell of a basin to the nearest cell outside it, exact for the cells as they are drawn.

Cells are rectangles of a width and a height. So the distance from the centre of a cell to another, i columns and j rows
away, is ``hypot(f, g)`` with ``f = (|i| - 1/2) width`` and ``g = (|j| - 1/2) height``. Here f is 0 for i = 0, and g
is 0 for j = 0. The square is separable, so two passes find the least distance:

1. in each row, the distance f from every cell to the nearest edge of an outside cell;
2. in each column, the lower envelope of the parabolas ``f^2 + (y - edge)^2`` over the horizontal edges between rows
   (half-integers; the height of each is the lesser f^2 of the two rows that it separates), and the row's own f^2.

Felzenszwalb and Huttenlocher, Distance transforms of sampled functions, Theory of Computing 8, 415 (2012).
"""

import math

import numpy as np

from rattle_kernels.numerics.jit import inlined, kernel


@inlined
def _row_distances(inside, wraps, distance):
    """Columns from each cell's centre to the nearest edge of a cell outside, both ways; inf where there is none."""
    columns = inside.size
    distance[:] = math.inf
    # Where time wraps, a second round carries the distance over the seam. Elsewhere the window's edges are outside.
    rounds = 2 if wraps else 1
    for backwards in range(2):
        away = math.inf if wraps else -0.5
        for i in range(rounds * columns):
            j = i % columns
            j = columns - 1 - j if backwards == 1 else j
            away = away + 1.0 if inside[j] else -0.5
            distance[j] = min(distance[j], max(away, 0.0))


@inlined
def _meet(height, p, q):
    """Where the parabolas of the edges p < q meet, in rows."""
    return ((height[q] + q * q) - (height[p] + p * p)) / (2.0 * (q - p))


@inlined
def _lower_envelope(height, edges, meets):
    """Find the edges whose parabolas are lowest somewhere, in order, and where each begins; return their number."""
    kept = 0
    for edge in range(height.size):
        if height[edge] == math.inf:
            continue
        begins = -math.inf
        while kept > 0:
            begins = _meet(height, edges[kept - 1], edge)
            if begins > meets[kept - 1]:
                break
            kept -= 1
            begins = -math.inf
        edges[kept], meets[kept] = edge, begins
        kept += 1
    return kept


@inlined
def _column_distances(square, height, edges, meets):
    """Replace squared distances along rows by squared distances in the plane, in units of a row's height."""
    rows = square.size
    # Edge k lies below row k. The window ends beneath the lowest and above the highest row.
    height[0] = height[rows] = 0.0
    for k in range(1, rows):
        height[k] = min(square[k - 1], square[k])
    kept = _lower_envelope(height, edges, meets)
    at = 0
    for row in range(rows):
        centre = row + 0.5
        while at + 1 < kept and meets[at + 1] <= centre:
            at += 1
        square[row] = min(square[row], height[edges[at]] + (centre - edges[at]) ** 2)


@kernel
def _transform(inside, wraps, stretch, square):
    rows, columns = inside.shape
    height, edges, meets = np.empty(rows + 1), np.empty(rows + 1, np.int64), np.empty(rows + 1)
    for row in range(rows):
        _row_distances(inside[row], wraps, square[row])
        for column in range(columns):
            square[row, column] = (square[row, column] * stretch) ** 2
    for column in range(columns):
        _column_distances(square[:, column], height, edges, meets)


def distance_outside(inside: np.ndarray, width: float, height: float, *, wraps: bool = False) -> np.ndarray:
    """Distance from the centre of each cell to the nearest cell that is not inside, or to the end of the window.

    Parameters
    ----------
    inside : ndarray of bool, shape (rows, columns)
        Whether a cell belongs to the set.
    width, height : float, positive
        Sides of a cell.
    wraps : bool
        Whether the last column is next to the first, so that the window ends above and below only.

    Returns
    -------
    ndarray of float64, that shape
        In the units of the sides; 0 for cells that are not inside.
    """
    square = np.empty(inside.shape)
    _transform(np.ascontiguousarray(inside, np.bool_), bool(wraps), width / height, square)
    return np.sqrt(square) * height
