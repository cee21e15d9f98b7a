"""What is not proven of a basin: pale by the part of each cell that is not, and hatched where that is half or more.

What is proven keeps its colour. Seen beside each other, hatching the proven part covered most of the plane and hid the
borders between basins, and lines alone missed what is thinner than their distance. Paleness shows every cell; lines
tell it from a motion of a pale colour, and are as far apart in a picture of any size.
"""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from rattle_proof.enclosures.cells import WHOLE
from rattle_proof.layout import PROVEN
from worker.additions import Mask
from worker.errors import InvalidJob
from worker.stores.layout import Variable

_VEIL, _VEIL_ALPHA = 1.0, 0.65
_HATCH: dict[str, Any] = {"hatch": "\\\\\\", "hatchcolor": "0.2", "hatch_linewidth": 0.5}
_HATCHED = 0.5
# Blocks each way, each hatched as a whole. On paper they are no wider than the lines. Drawn cell by cell, the outline
# of a million cells would make most of the file.
_MOST_BLOCKS = 512
_RECTANGLE = (Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY)

Extent = tuple[float, float, float, float]


def label_of(share: float | None) -> str:
    """What a legend says of the share of the plane that is not proven, None where it is not known."""
    return "not proven" if share is None else f"not proven   {100.0 * share:.2f} %"


def unproven_patch(label: str) -> Patch:
    """Legend entry of what is not proven."""
    return Patch(facecolor="0.85", edgecolor="black", label=label, **_HATCH)


def draw_unproven(axes: Axes, proven: np.ndarray, extent: Extent, share: float | None = None) -> None:
    """Draw over cells what of them is not proven.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Of the (t, v) plane.
    proven : ndarray of int, shape (rows, columns)
        Sixty-fourths of each cell that are proven, from the lowest speed upwards; any other number where it was not
        tried yet.
    extent : (float, float, float, float)
        Least and largest time, least and largest speed.
    share : float, optional
        Of the whole basin that is not proven, for a legend.

    Examples
    --------
    >>> import numpy as np
    >>> from matplotlib.figure import Figure
    >>> axes = Figure().subplots()
    >>> draw_unproven(axes, np.array([[64, 0]]), (0.0, 1.0, 0.0, 7.0), 0.5)
    >>> axes.patches[0].get_label()
    'not proven   50.00 %'
    """
    part = 1.0 - np.where((proven >= 0) & (proven <= WHOLE), proven, 0) / WHOLE
    veil = np.full((*part.shape, 4), _VEIL)
    veil[..., 3] = _VEIL_ALPHA * part
    axes.imshow(veil, origin="lower", extent=extent, aspect="auto", interpolation="nearest")
    hatched = PathPatch(
        _outline(part, extent), facecolor="none", edgecolor="none", linewidth=0.0, label=label_of(share), **_HATCH
    )
    axes.add_patch(hatched)


def share_unproven(proven: Iterable[np.ndarray | None]) -> float | None:
    """Share of cells that is not proven, from their sixty-fourths, part by part; None if not all parts are there."""
    parts, cells = 0, 0
    for each in proven:
        if each is None or (each > WHOLE).any():
            return None
        parts, cells = parts + int(each.sum(dtype=np.int64)), cells + each.size
    return 1.0 - parts / (WHOLE * cells)


class _Unproven(Mask):
    @property
    def variable(self) -> Variable:
        return PROVEN

    def demand(self, there: bool) -> None:
        if not there:
            raise InvalidJob("nothing is proven of this basin: the overlay proven needs a job with prove")

    def share(self, values: Iterable[np.ndarray | None]) -> float | None:
        return share_unproven(values)

    def draw(self, axes: Axes, values: np.ndarray, extent: Extent, share: float | None) -> None:
        draw_unproven(axes, values, extent, share)

    def legend(self, axes: Axes) -> list[Patch]:
        names = {str(patch.get_label()) for patch in axes.patches if isinstance(patch, PathPatch)}
        return [unproven_patch(name) for name in names]


UNPROVEN = _Unproven()


def _outline(part: np.ndarray, extent: Extent) -> Path:
    """Blocks of cells that are hatched, as rectangles: one for each run of a row."""
    down, across = (np.append(np.arange(0, cells, math.ceil(cells / _MOST_BLOCKS)), cells) for cells in part.shape)
    sums = np.add.reduceat(np.add.reduceat(part, down[:-1], axis=0), across[:-1], axis=1)
    marked = sums >= _HATCHED * np.outer(np.diff(down), np.diff(across))
    edges = np.diff(np.pad(marked, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    (row, start), stop = np.nonzero(edges == 1), np.nonzero(edges == -1)[1]
    times, speeds = (
        np.linspace(*ends, cells + 1)[at]
        for ends, cells, at in ((extent[:2], part.shape[1], across), (extent[2:], part.shape[0], down))
    )
    early, late, low, high = times[start], times[stop], speeds[row], speeds[row + 1]
    corners = np.array([(early, low), (late, low), (late, high), (early, high), (early, low)])
    return Path(corners.transpose(2, 0, 1).reshape(-1, 2), list(_RECTANGLE) * row.size)
