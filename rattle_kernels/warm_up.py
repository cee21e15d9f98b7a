"""Compile the kernels that the service needs, or load them from the disk cache, once and before work arrives."""

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from rattle_kernels.attractors.attractor_search import find_attractors
from rattle_kernels.attractors.classify import name_solutions
from rattle_kernels.attractors.loudness import loudness
from rattle_kernels.attractors.trap_table import build_trap_table
from rattle_kernels.cell_mapping.cell_grid import CellGrid
from rattle_kernels.cell_mapping.cell_groups import find_groups, label_cells
from rattle_kernels.cell_mapping.cell_map import PERMANENT_CONTACT, map_cells
from rattle_kernels.cell_mapping.image_set import has_members, mark_images, members_of, place_images, unite
from rattle_kernels.impact_map.capture_velocity import capture_velocity
from rattle_kernels.impact_map.flights import UPPER
from rattle_kernels.impact_map.grazing_velocity import grazing_velocity
from rattle_kernels.impact_map.pulse import departures_after_pulses
from rattle_kernels.impact_map.rest_velocity import rest_velocity
from rattle_kernels.impact_map.time_history import time_history
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.manifolds.grazing_preimages import grazing_preimages
from rattle_kernels.manifolds.saddle import find_saddle
from rattle_kernels.manifolds.stable_manifold import ManifoldLimits, stable_manifold
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.fused_multiply_add import fuses_multiply_add
from rattle_kernels.numerics.jit import KERNELS, watch_compiling
from rattle_kernels.orbits.bifurcation_diagram import bifurcation_diagram
from rattle_kernels.orbits.bifurcation_point import describe_point, point_near, shallowest_in_contact
from rattle_kernels.orbits.closure import OrbitShape
from rattle_kernels.orbits.continuation import continue_orbit
from rattle_kernels.orbits.loose_graze import loose_graze_near
from rattle_kernels.orbits.orbit_beyond_graze import orbit_beyond_graze
from rattle_kernels.orbits.orbit_contacts import contacts_from, rest_after
from rattle_kernels.orbits.orbit_equations import SpecialKind
from rattle_kernels.orbits.orbit_search import find_orbit, find_orbits
from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit
from rattle_kernels.orbits.touching_orbit import touches_of, touching_orbit

OF_ANALYSES = frozenset(
    {
        "impact_map.capture_velocity", "impact_map.grazing_distance", "impact_map.pulse", "impact_map.rest_velocity",
        "orbits.bifurcation_diagram", "orbits.bifurcation_point", "orbits.closure", "orbits.graze_kind",
        "orbits.loose_graze", "orbits.near_graze", "orbits.orbit_beyond_graze", "orbits.orbit_contacts",
        "orbits.orbit_equations", "orbits.orbit_search", "orbits.orbit_seeds", "orbits.touching_orbit",
    }
)  # fmt: skip
"""Modules whose kernels analyses and reports need, and basins do not."""
FROM_PYTHON_ALONE = frozenset(
    {
        "basin_measures.entropy", "basin_measures.integrity", "basin_measures.uncertainty_exponent",
        "impact_map.apply", "manifolds.tangency", "numerics.distance_transform",
    }
)  # fmt: skip
"""Modules whose kernels a service compiles when they are first asked for: few ask for what they compute."""

Report = Callable[[int, int], None]
"""Called with how many kernels are there and how many are needed, while some have to be compiled; else not at all."""

_STIFF = Oscillator(stiffness=1e4)
# Damping so weak that the adiabatic invariant bounds low bounces, and that traps pay.
_WEAK = Oscillator(damping=6e-4, eccentricity=1e-5, half_backlash=6e-4)
# Beyond Eq. (8).
_LOOSE = Oscillator(eccentricity=0.2)
# Where P(1,1,0) of loose gears grazes +beta.
_GRAZING, _GRAZING_T, _GRAZING_V = Oscillator(0.1, 0.0790754296, 0.3, restitution=0.7), 0.5392694, 0.5174388
# Where its flight grazes -beta.
_AT_GRAZE, _AT_GRAZE_T, _AT_GRAZE_V = Oscillator(0.764661554, 0.096608), 0.75700007, 4.80451024
# Departures of P(1,1,0), and of chaos.
_T, _V = 0.89829, 3.76991
# A speed that meets -beta from anywhere.
_MEETING = 8.0
_CHAOTIC_T, _CHAOTIC_V = 0.553, 4.703


def _is_own(kernel: Any) -> bool:
    """Whether a kernel is of this package. One of a package beside is compiled when it is first needed."""
    return str(kernel.py_func.__module__).startswith("rattle_kernels.")


@contextlib.contextmanager
def _reporting(report: Report | None, needed: Callable[[str], bool]) -> Iterator[None]:
    """Report how many kernels of the modules that are needed have been compiled, or loaded, so far."""
    own = {each: str(each.py_func.__module__).removeprefix("rattle_kernels.") for each in KERNELS if _is_own(each)}
    kernels = [each for each, module in own.items() if needed(module)]
    compiled = False

    def tell() -> None:
        nonlocal compiled
        compiled = True
        if report is not None:
            report(sum(bool(each.signatures) for each in kernels), len(kernels))

    with watch_compiling(tell):
        yield
    if compiled:
        tell()


def reporting_compilation(report: Report | None, *, analyses: bool = False) -> contextlib.AbstractContextManager[None]:
    """Report kernels that have to be compiled while a context lasts, as `warm_up` does; none is run for that.

    Parameters
    ----------
    report : callable, optional
    analyses : bool
        Whether those of analyses are counted, or those of basins.

    Returns
    -------
    context manager
    """
    return _reporting(report, lambda module: module not in FROM_PYTHON_ALONE and (module in OF_ANALYSES) == analyses)


def warm_up(report: Report | None = None) -> None:
    """Run every kernel of basins, of their pictures and of grazing curves once, on a few cells.

    Parameters
    ----------
    report : callable, optional
        Called with how many kernels are there and how many are needed, before each that has to be compiled and when all
        are there; not called where all of them load from the disk cache.
    """
    with reporting_compilation(report):
        _run_kernels_of_basins()


def _run_kernels_of_basins() -> None:
    fuses_multiply_add()
    oscillator = Oscillator()
    grid = CellGrid(time_cells=4, velocity_cells=4)
    images = map_cells(oscillator, grid, 1, (0, 4), (0, 4))
    # Seeds that settle on the periodic orbit and on the chaotic attractor: both kinds are recognised by other kernels.
    attractors = find_attractors(oscillator, [_T, _CHAOTIC_T], [_V, _CHAOTIC_V])
    name_solutions(oscillator, attractors, [0.9], [3.77])
    # Twice around P(1,1,0), so that the search for its own period runs, too.
    find_periodic_orbit(oscillator, _T, _V, 2, 5.0)
    members = unite(grid.cells, [mark_images(grid.cells, images.image_cell)])
    place = np.empty(members.size, np.int32)
    if has_members(members, (0, 4), (0, 4), grid.time_cells):
        place_images(members, (0, 0), grid.time_cells, images.image_cell, place)
    members_of(members)
    tail_too_long_for_int16 = np.arange(-1, np.iinfo(np.int16).max, dtype=np.int32)
    for places in (place, tail_too_long_for_int16):
        label_cells(find_groups(members, places), np.arange(grid.cells), images.image_cell.ravel())
    # Where all cells fall quiet there are no images, and empty arrays are of a type of their own.
    nothing = find_groups(unite(grid.cells, []), np.empty(0, np.int32))
    label_cells(nothing, np.arange(grid.cells), np.full(grid.cells, PERMANENT_CONTACT))
    build_trap_table(oscillator, attractors)
    loudness(oscillator, attractors[1])
    for other in (_STIFF, _WEAK):
        lane_tables(other)
    warm_up_curves()
    for each in (oscillator, _LOOSE):
        grazing_preimages(each, 1)


def warm_up_curves() -> None:
    """Run the kernels of grazing curves and time histories once."""
    for each in (Oscillator(), _LOOSE):
        grazing_velocity(each, 0.0)
    time_history(Oscillator(), 0.0, 0.0, 0.0, periods=1.0)


def warm_up_analyses(report: Report | None = None) -> None:
    """Run every kernel of searches for orbits, of continuation, diagrams, manifolds and reports once.

    Parameters
    ----------
    report : callable, optional
        As that of `warm_up`; kernels that basins need as well are not counted.
    """
    with reporting_compilation(report, analyses=True):
        _run_kernels_of_analyses()


def _run_kernels_of_analyses() -> None:
    oscillator = Oscillator()
    capture_velocity(oscillator, 0.0)
    rest_velocity(_GRAZING, 0.5)
    for each in (oscillator, _STIFF):
        departures_after_pulses(each, 0.25, 2.0)
    find_orbits(oscillator, longest=1, cells=2)
    found = find_orbit(oscillator, _T, _V)
    assert found is not None
    continue_orbit(oscillator, found.orbit, "damping", (0.599, 0.601))
    bifurcation_diagram(oscillator, "damping", [0.6], [_T], [_V], transient=1, kept=2)
    point_near(SpecialKind.GRAZING, oscillator, "damping", OrbitShape(1, 1), _T, _V)
    point_near(SpecialKind.CONTACT_LOSS, _STIFF, "stiffness", OrbitShape(1, 2), _T, _V)
    describe_point(SpecialKind.CONTACT_LOSS, "stiffness", OrbitShape(1, 2), _STIFF, _T, 0.0, residual=0.0, error=0.0)
    orbit_beyond_graze(
        describe_point(
            SpecialKind.GRAZING, "damping", OrbitShape(1, 1, 1), _AT_GRAZE, _AT_GRAZE_T, _AT_GRAZE_V,
            residual=0.0, error=0.0,
        )
    )  # fmt: skip
    shallowest_in_contact(_STIFF, found.orbit.t, found.orbit.v)
    loose_graze_near(_GRAZING, "eccentricity", 1, np.array([_GRAZING_T]), np.array([_GRAZING_V]), 0)
    rest_after(_GRAZING, contacts_from(_GRAZING, UPPER, _GRAZING_T, -_GRAZING_V, 1), 0)
    touching_orbit(_STIFF, "damping", OrbitShape(1, 1), (0,), touches_of(_STIFF, found.orbit.t, np.array([_MEETING])))
    stable_manifold(oscillator, find_saddle(oscillator, 0.6, 3.77), ManifoldLimits(0.1, 0.0, 7.0))
