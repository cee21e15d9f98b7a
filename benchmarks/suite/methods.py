"""Methods that do the suite's work: this project's, and the plain ones that the others are compared with.

A method is a function from inputs to an answer. `method` enters it for a workload; other projects enter theirs alike.
"""

import tempfile
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from typing import Any, Protocol

import numpy as np

import rattle
from benchmarks.paper_recipe import apply_recipe
from benchmarks.plain_newton import apply_plainly, plain_grazing_table
from benchmarks.suite.workloads import (
    APPLICATIONS,
    ITERATIONS,
    OSCILLATOR,
    QUIET,
    RATTLES,
    STIFF,
    Boxes,
    Departures,
    Panel,
    ends_of,
)
from rattle.local import usable_cores
from rattle_kernels import CellGrid, Oscillator, basin, grazing_velocity, next_impacts
from rattle_proof.enclosures.impact import LOST, enclose_images
from rattle_proof.enclosures.machine import machine_of

PLAIN = "plain"
"""Name of the methods that the others are compared with."""
ONE_CORE, ALL_CORES = "gear-rattle", "gear-rattle, all cores"
# Parts for each core: the last to end leaves others idle for less of the time.
_PARTS_OF_CORE = 4


class Compute(Protocol):
    """What a method is: it answers to the inputs that it is given, one item for each of theirs.

    An answer to `Departures` has shape (n, 2), the phases and speeds of their images; one to a `Panel` (rows, columns),
    the ends of its cells; one to `Boxes` (n, 4), least and greatest time and speed of their images, not numbers where
    there is no enclosure.
    """

    def __call__(self, inputs: Any, /) -> np.ndarray: ...


@dataclass(frozen=True)
class Method:
    """A method and what it needs.

    Parameters
    ----------
    name : str
        One method may have an entry for each workload.
    workload : str
        Name of the workload.
    compute : Compute
    every : int
        It takes one in so many inputs along each axis, a power of five: slow methods take few.
    cores : int
        How many cores it keeps busy.
    needs : tuple of str
        Top-level packages without which it does not run.
    """

    name: str
    workload: str
    compute: Compute
    every: int = 1
    cores: int = 1
    needs: tuple[str, ...] = ()

    @property
    def missing(self) -> list[str]:
        """Packages that it needs and that are not installed."""
        return [package for package in self.needs if find_spec(package) is None]


METHODS: list[Method] = []
"""Those of all workloads, in the order in which they run."""


def method(
    name: str, workload: str, every: int = 1, cores: int = 1, needs: Iterable[str] = ()
) -> Callable[[Compute], Compute]:
    """Enter a function in `METHODS`; parameters as `Method` has them."""

    def enter(compute: Compute) -> Compute:
        METHODS.append(Method(name, workload, compute, every, cores, tuple(needs)))
        return compute

    return enter


def _on_all_cores(compute: Compute, inputs: Departures | Boxes) -> np.ndarray:
    """Parts of the inputs by threads: kernels hold no lock of Python's."""
    parts = [np.array_split(array, _PARTS_OF_CORE * usable_cores()) for array in inputs]
    with ThreadPoolExecutor(usable_cores()) as threads:
        return np.concatenate(list(threads.map(compute, map(type(inputs), *parts))))


@method(ONE_CORE, "applications")
def images(departures: Departures) -> np.ndarray:
    """Images by lanes."""
    return np.stack(next_impacts(OSCILLATOR, *departures, APPLICATIONS)[:2], axis=1)


method(ALL_CORES, "applications", cores=usable_cores())(partial(_on_all_cores, images))


def _end(quiet: bool, upper_contacts: int) -> int:
    """End of cells whose motion has so many contacts with +beta in a turn; chaos has none that is counted."""
    return QUIET if quiet else upper_contacts or RATTLES


def _grid(panel: Panel) -> CellGrid:
    return CellGrid(time_cells=panel.times.size, velocity_cells=panel.speeds.size)


def _ends_in_memory(oscillator: Oscillator, panel: Panel) -> np.ndarray:
    found = basin(oscillator, _grid(panel), ITERATIONS)
    ends = [_end(each.name == "permanent contact", each.upper_contacts) for each in found.attractors]
    return np.array(ends, np.uint8)[found.solution]


def _ends_through_store(stiffness: float | None, panel: Panel) -> np.ndarray:
    """By threads of this process; a store is written as well."""
    with tempfile.TemporaryDirectory() as folder:
        cells = panel.times.size, panel.speeds.size
        found = rattle.basin(
            stiffness=stiffness, cells=cells, iterations=ITERATIONS, store=f"{folder}/basin.zarr", progress=False
        )
        attractors = found.rattle.attractors
        named = zip(attractors.name.values, attractors.upper_contacts.values, strict=True)
        ends = [_end(name == "permanent contact", int(contacts)) for name, contacts in named]
        return np.array(ends, np.uint8)[found.solution.values]


method(ONE_CORE, "basin")(partial(_ends_in_memory, OSCILLATOR))
method(ALL_CORES, "basin", cores=usable_cores())(partial(_ends_through_store, None))
method(ONE_CORE, "stiff basin")(partial(_ends_in_memory, STIFF))
method(ALL_CORES, "stiff basin", cores=usable_cores())(partial(_ends_through_store, STIFF.stiffness))


@method(ONE_CORE, "boxes")
def hulls(boxes: Boxes) -> np.ndarray:
    """Enclosures of images."""
    enclosed = enclose_images(machine_of(OSCILLATOR), OSCILLATOR, boxes.edges)
    return np.where((enclosed.states == LOST)[:, None], np.nan, enclosed.hulls)


method(ALL_CORES, "boxes", cores=usable_cores())(partial(_on_all_cores, hulls))

_GRAZING = plain_grazing_table(grazing_velocity, OSCILLATOR)


def _plainly(t: np.ndarray, v: np.ndarray, applications: int) -> Departures:
    t, v = t.copy(), v.copy()
    apply_plainly(*OSCILLATOR[:3], _GRAZING, t, v, applications)
    return Departures(t, v)


def _by_recipe(t: np.ndarray, v: np.ndarray, applications: int) -> Departures:
    t, v = t.copy(), v.copy()
    apply_recipe(*STIFF[:4], _GRAZING, t, v, applications)
    return Departures(t, v)


@method(PLAIN, "applications", every=25)
def plain_images(departures: Departures) -> np.ndarray:
    """Newton's method in scalar code."""
    return np.stack(_plainly(*departures, APPLICATIONS), axis=1)


@method(PLAIN, "basin", every=25)
def plain_ends(panel: Panel) -> np.ndarray:
    """Newton's method in scalar code, all applications of every cell."""
    return ends_of(_plainly, panel.centres).reshape(panel.speeds.size, -1)


@method(PLAIN, "stiff basin", every=25)
def ends_by_recipe(panel: Panel) -> np.ndarray:
    """The paper's recipe in scalar code, all applications of every cell that does not stay in contact."""
    return ends_of(_by_recipe, panel.centres).reshape(panel.speeds.size, -1)
