"""Boundaries of the paper's basins (Sec. 6): the grazing curve with its pre-images, and the manifolds of A and B."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import xarray as xr

from rattle import BasinJob
from rattle.pictures import Lines, Marks, manifold_lines, saddle_marks
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
from rattle_paper.numbers.orbits import orbit_summary, orbits_named
from rattle_paper.papers_oscillator import papers_basin

BASIN = "basin"
# Colours of Fig. 15, and line widths. B's manifold stays visible between the stripes of A's.
_STYLES = {"A": ("magenta", 0.8), "B": ("lime", 1.2)}
_PREIMAGES = 2


class Manifold(NamedTuple):
    """A saddle and the branches of its stable manifold."""

    saddle: PeriodicOrbit
    branches: tuple[ManifoldBranch, ...]

    @property
    def pieces(self) -> list[Piece]:
        """Pieces of all branches."""
        return [piece for branch in self.branches for piece in branch.pieces]


def the_basin(grid: CellGrid) -> dict[str, BasinJob]:
    """The basin of the paper's Figs. 14 to 16, which is that of Fig. 7 (bottom)."""
    return {BASIN: papers_basin(grid)}


def saddles(oscillator: Oscillator) -> dict[str, PeriodicOrbit]:
    """The saddles A, P(1,1,0), from its closed form, and B, P(1,1,1).

    B is the slower of the two saddles P(1,1,1). It lies on a basin boundary, the other one within chaos.
    """
    _, closed_form = single_contact_orbits(oscillator)
    return {
        "A": find_saddle(oscillator, closed_form.t, closed_form.v),
        "B": orbits_named(oscillator, "P(1,1,1)")[0].orbit,
    }


def manifolds(oscillator: Oscillator, arclength: float, highest: float) -> dict[str, Manifold]:
    """Stable manifolds of A and B up to a given speed."""
    limits = ManifoldLimits(arclength=arclength, highest_velocity=highest)
    return {
        label: Manifold(saddle, stable_manifold(oscillator, saddle, limits))
        for label, saddle in saddles(oscillator).items()
    }


def preimages(oscillator: Oscillator, highest: float) -> tuple[tuple[Piece, ...], ...]:
    """The grazing curve and its first and second pre-images up to a given speed."""
    return grazing_preimages(oscillator, _PREIMAGES, velocity_limits=(0.0, highest))


def manifold_overlays(grown: dict[str, Manifold]) -> list[Lines]:
    """The manifold of A in magenta and of B in green, as in Fig. 15. A's is longer and lies below."""
    return [
        manifold_lines(each.branches, f"stable manifold of {each.saddle.name}, {label}", *_STYLES[label])
        for label, each in grown.items()
    ]


def saddle_overlays(grown: dict[str, Manifold]) -> tuple[Marks, ...]:
    """Marks on A and B."""
    return saddle_marks(each.saddle for each in grown.values())


def share_of_boundaries(basin: xr.Dataset, pieces: Iterable[Piece]) -> float:
    """Share of the boundary cells shown that lie within one cell of the curves."""
    solution = basin.rattle.shown.solution
    shown = basin.rattle.job.grid._replace(time_cells=solution.sizes["time"], velocity_cells=solution.sizes["velocity"])
    return boundary_share(solution, shown, pieces)


def manifold_summary(manifold: Manifold) -> dict[str, Any]:
    """The saddle, and the length, the number of points and the end of each branch."""
    branches = [
        {
            "arclength": branch.arclength,
            "points": sum(piece.t.size for piece in branch.pieces),
            "end": branch.end.value,
        }
        for branch in manifold.branches
    ]
    return {"saddle": orbit_summary(manifold.saddle), "branches": branches}
