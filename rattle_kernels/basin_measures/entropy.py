"""Basin entropy: the uncertainty of the final motion at the scale of a box.

The picture is divided into boxes of e x e cells. In box i a share p_ij of the cells ends in motion j, so its Gibbs
entropy is ``S_i = -sum_j p_ij ln p_ij``. The basin entropy S_b is the mean over all N boxes. The boundary basin entropy
S_bb is the mean over the N_b boxes that contain more than one motion:

    S_b = (sum_i S_i)/N,    S_bb = (sum_i S_i)/N_b

If boundaries are smooth, one curve divides nearly every boundary box into two parts, so S_bb <= ln 2. Hence the
*ln 2 criterion*: S_bb > ln 2 implies fractal boundaries. It is sufficient, not necessary: with two motions S_i <= ln 2
for any boundary.

Daza, Wagemakers, Georgeot, Guéry-Odelin and Sanjuán, Basin entropy: a new tool to analyze uncertainty in dynamical
systems, Sci. Rep. 6, 31416 (2016).
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.basin_measures.arrays import check_basins
from rattle_kernels.numerics.jit import kernel


class BasinEntropy(NamedTuple):
    """Entropies of a picture, in natural units, and the numbers of boxes averaged.

    ``basin_entropy`` is S_b, ``boundary_entropy`` S_bb (NaN if no box contains a boundary). Of the ``boxes``,
    ``boundary_boxes`` contain more than one motion.
    """

    basin_entropy: float
    boundary_entropy: float
    boxes: int
    boundary_boxes: int

    @property
    def fractal(self) -> bool:
        """Whether the boundaries are fractal by the ln 2 criterion; False is inconclusive."""
        return self.boundary_entropy > math.log(2.0)


@kernel
def _box_entropies(solution, box_cells, entropy):
    count = np.zeros(solution.max() + 1, np.int64)
    cells = box_cells * box_cells
    for row in range(entropy.shape[0]):
        for column in range(entropy.shape[1]):
            box = solution[row * box_cells : (row + 1) * box_cells, column * box_cells : (column + 1) * box_cells]
            for motion in box.flat:
                count[motion] += 1
            total = 0.0
            for motion in box.flat:  # each motion once: its count is then reset
                if count[motion] > 0:
                    part = count[motion] / cells
                    total -= part * math.log(part)
                    count[motion] = 0
            entropy[row, column] = total


def basin_entropy(solution: np.typing.ArrayLike, box_cells: int = 5) -> BasinEntropy:
    """Basin entropy S_b and boundary basin entropy S_bb.

    Parameters
    ----------
    solution : array_like of int, shape (velocity cells, time cells)
        Index of the motion that each cell ends in; none negative.
    box_cells : int
        Linear size e of a box, at least 2. The default of 5 is the paper's choice. Boxes do not overlap. Rows and
        columns left over at the upper ends are not counted.

    Returns
    -------
    BasinEntropy

    Raises
    ------
    ValueError
        If a cell has no solution, or no box fits into the picture.

    Notes
    -----
    ``S_b = (1/N) sum_i S_i`` and ``S_bb = (1/N_b) sum_i S_i`` with ``S_i = -sum_j p_ij ln p_ij`` (Daza et al., 2016).
    For N motions at random, a box of e^2 cells gives about ln N - (N - 1)/(2 e^2): small boxes underestimate.
    """
    array = check_basins(solution)
    if not 2 <= box_cells <= min(array.shape):
        raise ValueError(f"box_cells must be between 2 and {min(array.shape)}, the shorter side, not {box_cells}")
    entropy = np.empty((array.shape[0] // box_cells, array.shape[1] // box_cells))
    _box_entropies(array, int(box_cells), entropy)
    boundary = int((entropy > 0.0).sum())
    total = float(entropy.sum())
    return BasinEntropy(total / entropy.size, total / boundary if boundary else math.nan, entropy.size, boundary)
