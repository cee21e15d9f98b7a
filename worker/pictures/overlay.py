"""Overlays of a picture of basins: curves and marked departures, at the phases that the picture shows.

Pieces of a curve are drawn separately, never joined across a break. A piece that runs beyond the last phase of the
picture continues at its first.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes

from rattle_kernels import (
    Attractor,
    AttractorKind,
    ManifoldBranch,
    Oscillator,
    PeriodicOrbit,
    Piece,
    grazing_preimages,
    grazing_velocity,
)
from rattle_kernels.manifolds.polyline import split_at_wrap

# Points of the grazing curve: it bends little.
_CURVE_POINTS = 513
# Colours of the grazing curve and its pre-images, by order (Figs. 14 and 16).
_BY_ORDER = ("white", "black", "yellow")


class Lines(NamedTuple):
    """Curves of one kind.

    Phases of ``pieces`` may exceed a period. ``label`` is for a legend, ``width`` in points, ``style`` matplotlib's.

    Examples
    --------
    >>> import numpy as np
    >>> from matplotlib.figure import Figure
    >>> from rattle_kernels import Piece
    >>> axes = Figure().subplots()
    >>> Lines("a curve", "white", (Piece(np.array([0.1, 0.2]), np.array([1.0, 2.0])),)).draw(axes)
    >>> axes.lines[0].get_label()
    'a curve'
    """

    label: str
    colour: str
    pieces: tuple[Piece, ...]
    width: float = 1.0
    style: str = "-"

    def draw(self, axes: Axes, time_start: float = 0.0) -> None:
        """Draw them on axes that show one period from ``time_start`` on."""
        parts = split_at_wrap(Piece(piece.t - time_start, piece.v) for piece in self.pieces)
        # One line with gaps draws thousands of pieces as fast as one.
        gap = np.array([np.nan])
        t, v = ([array for part in parts for array in (part[axis], gap)] for axis in (0, 1))
        if parts:
            axes.plot(
                time_start + np.concatenate(t), np.concatenate(v), self.style, color=self.colour,
                linewidth=self.width, label=self.label,
            )  # fmt: skip


class Marks(NamedTuple):
    """Marked departures. ``marker`` is matplotlib's, ``size`` its size in points.

    Examples
    --------
    >>> import numpy as np
    >>> from matplotlib.figure import Figure
    >>> axes = Figure().subplots()
    >>> Marks("departures", "red", np.array([0.1, 0.5]), np.array([1.0, 2.0]), "x").draw(axes)
    >>> axes.lines[0].get_label()
    'departures'
    """

    label: str
    colour: str
    t: np.ndarray
    v: np.ndarray
    marker: str
    size: float = 7.0

    def draw(self, axes: Axes, time_start: float = 0.0) -> None:
        """Draw them on axes that show one period from ``time_start`` on."""
        t = time_start + (self.t - time_start) % 1.0
        axes.plot(
            t, self.v, self.marker, color=self.colour, markersize=self.size,
            markeredgewidth=0.0 if self.marker == "." else 1.6, label=self.label,
        )  # fmt: skip


Overlay = Lines | Marks
"""What can be laid over a basin: curves or marks."""


def attractor_marks(attractors: Iterable[Attractor], colour: str = "white") -> tuple[Marks, ...]:
    """Crosses of one colour on the departures of periodic attractors, and black dots on those of chaos.

    Parameters
    ----------
    attractors : iterable of Attractor
    colour : str
        Of the crosses, as Matplotlib names colours.

    Returns
    -------
    tuple of Marks
        One for each attractor that has departures.

    Examples
    --------
    >>> import rattle
    >>> basin = rattle.basin(cells=40, progress=False)
    >>> [marks.label for marks in attractor_marks(basin.rattle.catalogue())]
    ['P(1,1,0)', 'chaotic']
    """
    marks = []
    for attractor in attractors:
        if attractor.kind == AttractorKind.PERIODIC:
            marks.append(Marks(attractor.name, colour, attractor.time, attractor.velocity, "x"))
        elif attractor.is_chaotic:
            marks.append(Marks(attractor.name, "black", attractor.time, attractor.velocity, ".", 1.0))
    return tuple(marks)


def saddle_marks(saddles: Iterable[PeriodicOrbit], colour: str = "white") -> tuple[Marks, ...]:
    """Upright crosses on the departures of saddles, as in Fig. 10.

    Parameters
    ----------
    saddles : iterable of PeriodicOrbit
    colour : str
        As Matplotlib names colours.

    Returns
    -------
    tuple of Marks
        One for each saddle.

    Examples
    --------
    >>> from rattle_kernels import Oscillator, find_saddle
    >>> [marks.label for marks in saddle_marks([find_saddle(Oscillator(), 0.6017, 3.7699)])]
    ['saddle P(1,1,0)']
    """
    return tuple(Marks(f"saddle {saddle.name}", colour, saddle.t, saddle.v, "+", 9.0) for saddle in saddles)


def grazing_line(oscillator: Oscillator) -> Lines:
    """The grazing curve of either model, in white: v*(t), or of a loose gear with impacts the curve of all its grazes.

    Parameters
    ----------
    oscillator : Oscillator

    Returns
    -------
    Lines

    Examples
    --------
    >>> from rattle_kernels import Oscillator
    >>> grazing_line(Oscillator()).label
    'grazing curve'
    """
    if oscillator.is_loose and math.isinf(oscillator.stiffness):
        (pieces,) = grazing_preimages(oscillator, 0)
        return Lines("grazing curve", _BY_ORDER[0], pieces, 1.4)
    t = np.linspace(0.0, 1.0, _CURVE_POINTS)
    return Lines("grazing curve", _BY_ORDER[0], (Piece(t, grazing_velocity(oscillator, t)),), 1.4)


def preimage_lines(orders: Iterable[Iterable[Piece]], of: str = "grazing") -> tuple[Lines, ...]:
    """Pre-images of the grazing curve, or of another.

    Parameters
    ----------
    orders : iterable of iterable of Piece
        Orders 1, 2, ..., as `grazing_preimages` returns them after the curve itself.
    of : str
        What they are pre-images of, for labels.

    Returns
    -------
    tuple of Lines
        One for each order.

    Examples
    --------
    >>> from rattle_kernels import Oscillator, grazing_preimages
    >>> [lines.label for lines in preimage_lines(grazing_preimages(Oscillator(), 1)[1:])]
    ['pre-image 1 of grazing']
    """
    return tuple(
        Lines(f"pre-image {order} of {of}", _BY_ORDER[1 + (order - 1) % (len(_BY_ORDER) - 1)], tuple(pieces))
        for order, pieces in enumerate(orders, 1)
    )


def manifold_lines(branches: Iterable[ManifoldBranch], label: str, colour: str, width: float = 1.0) -> Lines:
    """All branches of a saddle's manifold.

    Parameters
    ----------
    branches : iterable of ManifoldBranch
        Of `stable_manifold` or `unstable_manifold`.
    label : str
        For a legend.
    colour : str
        As Matplotlib names colours.
    width : float
        In points.

    Returns
    -------
    Lines

    Examples
    --------
    >>> from rattle_kernels import ManifoldLimits, Oscillator, find_saddle, stable_manifold
    >>> saddle = find_saddle(Oscillator(), 0.6017, 3.7699)
    >>> branches = stable_manifold(Oscillator(), saddle, ManifoldLimits(arclength=1.0, highest_velocity=7.0))
    >>> len(manifold_lines(branches, "stable manifold", "magenta").pieces) >= 2
    True
    """
    return Lines(label, colour, tuple(piece for branch in branches for piece in branch.pieces), width)
