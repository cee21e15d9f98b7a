"""What the boundaries of the paper's basins are made of (Sec. 6): its curves, the saddles A and B, their manifolds."""

from collections.abc import Iterable
from typing import Any, NamedTuple

from rattle.paper.numbers.orbits import orbits_named, told_orbit
from rattle.paper.panels.basin_view import BasinView
from rattle.paper.papers_oscillator import papers_basin
from rattle_kernels import (
    CellGrid,
    ManifoldBranch,
    ManifoldLimits,
    Oscillator,
    PeriodicOrbit,
    Piece,
    boundary_share,
    find_saddle,
    grazing_preimages,
    single_contact_orbits,
    stable_manifold,
)
from worker.jobs.basin_job import BasinJob
from worker.pictures.overlay import Lines, Marks, manifold_lines, saddle_marks

BASIN = "basin"
# Colours of Fig. 15, and widths: B's stays visible between the stripes of A's.
_STYLES = {"A": ("magenta", 0.8), "B": ("lime", 1.2)}
_PREIMAGES = 2


class Manifold(NamedTuple):
    """A saddle and the branches of its stable manifold."""

    saddle: PeriodicOrbit
    branches: tuple[ManifoldBranch, ...]

    @property
    def pieces(self) -> list[Piece]:
        """Those of all branches."""
        return [piece for branch in self.branches for piece in branch.pieces]


def the_basin(grid: CellGrid) -> dict[str, BasinJob]:
    """The basin that the paper's Figs. 14 to 16 lie on: that of Fig. 7 (bottom)."""
    return {BASIN: papers_basin(grid)}


def saddles(oscillator: Oscillator) -> dict[str, PeriodicOrbit]:
    """A, P(1,1,0), from its closed form, and B, P(1,1,1).

    Of the two saddles P(1,1,1), B is the slower one: it lies on a boundary of basins, the other one amid chaos.
    """
    _, closed_form = single_contact_orbits(oscillator)
    return {
        "A": find_saddle(oscillator, closed_form.t, closed_form.v),
        "B": orbits_named(oscillator, "P(1,1,1)")[0].orbit,
    }


def manifolds(oscillator: Oscillator, arclength: float, highest: float) -> dict[str, Manifold]:
    """Stable manifolds of A and B up to a speed."""
    limits = ManifoldLimits(arclength=arclength, highest_velocity=highest)
    return {
        label: Manifold(saddle, stable_manifold(oscillator, saddle, limits))
        for label, saddle in saddles(oscillator).items()
    }


def preimages(oscillator: Oscillator, highest: float) -> tuple[tuple[Piece, ...], ...]:
    """The grazing curve and its first and second pre-image up to a speed."""
    return grazing_preimages(oscillator, _PREIMAGES, velocity_limits=(0.0, highest))


def manifold_overlays(grown: dict[str, Manifold]) -> list[Lines]:
    """A's magenta and B's green, as in Fig. 15; A's, which is the longer one, below."""
    return [
        manifold_lines(each.branches, f"stable manifold of {each.saddle.name}, {label}", *_STYLES[label])
        for label, each in grown.items()
    ]


def saddle_overlays(grown: dict[str, Manifold]) -> tuple[Marks, ...]:
    """Marks on A and B."""
    return saddle_marks(each.saddle for each in grown.values())


def share_of_boundaries(view: BasinView, pieces: Iterable[Piece]) -> float:
    """Share of the boundary cells that are shown within one cell of curves."""
    rows, columns = view.solution.shape
    return boundary_share(view.solution, view.job.grid._replace(time_cells=columns, velocity_cells=rows), list(pieces))


def told_manifold(manifold: Manifold) -> dict[str, Any]:
    """The saddle, and of each branch its length, its points, and why it ends."""
    branches = [
        {
            "arclength": branch.arclength,
            "points": sum(piece.t.size for piece in branch.pieces),
            "end": branch.end.value,
        }
        for branch in manifold.branches
    ]
    return {"saddle": told_orbit(manifold.saddle), "branches": branches}
