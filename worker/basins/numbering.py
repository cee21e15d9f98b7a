"""Numbers of solutions: each solution has the same number in all basins of a sweep.

Every basin finds its own catalogue, independently of its neighbours. Then, in the order of basins:

1. Each periodic attractor of a neighbour is continued by Newton's method to the basin's parameters. If that ends on an
   attractor of the basin, the two are one solution. If it ends on one that the basin's catalogue lacks (it attracts no
   cell of the grid), that attractor is added, with a share of 0.
2. The attractors that remain are matched by kind and itinerary, the closest first.
3. The neighbours lack the rest. Each takes the number of a solution of its kind and itinerary that the basin does not
   have yet, since an itinerary names a motion across a sweep. If there are several, it takes the one seen last. If
   there is none, it takes the next number.

The neighbours are the previous basin along the last axis and, for solutions that this one lacks, the
previous basin along the first. So the numbers depend on the catalogues alone, not on the order in which they are found.

A phase comes around: 0 and 1 are the same machine. Its only neighbour is then the earlier basin of that machine, so
that both have the same numbers, whatever happened on the way.
"""

from collections.abc import Callable
from typing import NamedTuple

from rattle_kernels import Attractor, Oscillator, attractor_distance, continue_attractor
from worker.jobs.basin_job import BasinJob
from worker.jobs.design import changes_at
from worker.jobs.swept_parameter import is_phase
from worker.stores.solution_table import Motion, SolutionTable, motion_of

# Newton's method converges to 1e-11. Orbits closer than this are the same.
_SAME_ORBIT = 1e-6
_POINTS_KEPT = 256
# Phases that agree to so many digits are the same machine; values between a start and a stop are rounded to 15.
_PHASE_DIGITS = 12

Catalogue = tuple[Attractor, ...]


class Numbered(NamedTuple):
    """Attractors of a basin, those of its own catalogue first, and the number of each."""

    attractors: Catalogue
    numbers: list[int]


class Numbering:
    """Numbers the solutions of one basin after another.

    Parameters
    ----------
    job : BasinJob
    table : SolutionTable
        Solutions of the basins that are already numbered. New ones are appended.
    read : callable
        Returns the numbered attractors of a basin that an earlier run has numbered.
    """

    def __init__(self, job: BasinJob, table: SolutionTable, read: Callable[[int], Numbered]) -> None:
        self.job, self.table, self._read = job, table, read
        # The previous basin along the first axis lies a whole row of basins back.
        self._kept = 1 if len(job.axes) < 2 else job.sweep_shape[-1]
        self._recent: dict[int, Numbered] = {}
        self._seen = table.last_seen()
        self._earlier_twin = _earlier_twins(job)
        self._twins: dict[int, Numbered] = {}

    def _neighbours(self, basin: int) -> list[int]:
        place, row = self.job.place_of(basin), self.job.sweep_shape[-1] if self.job.axes else 1
        before = [basin - 1] if place and place[-1] > 0 else []
        return before + ([basin - row] if len(place) == 2 and place[0] > 0 else [])

    def _of(self, basin: int) -> Numbered:
        if basin not in self._recent:
            self._keep(basin, self._read(basin))
        return self._recent[basin]

    def _keep(self, basin: int, numbered: Numbered) -> None:
        self._recent[basin] = Numbered(tuple(_thinned(each) for each in numbered.attractors), numbered.numbers)
        while len(self._recent) > self._kept + 1:
            del self._recent[min(self._recent)]

    def _known(self, basin: int) -> list[Numbered]:
        """Numbered attractors of the basin's neighbours; where it is an earlier basin's machine, of that one alone."""
        twin = self._earlier_twin.get(basin)
        if twin is None:
            return [self._of(neighbour) for neighbour in self._neighbours(basin)]
        if twin not in self._twins:
            self._twins[twin] = self._read(twin)
        return [self._twins[twin]]

    def _earlier(self, motion: Motion, number_of: dict[int, int]) -> int | None:
        """Number of a motion that the basin does not have yet. If there are several, the one seen last."""
        free = [
            number
            for number, listed in enumerate(self.table.motions)
            if listed == motion and number not in number_of.values()
        ]
        return max(free, key=lambda number: (self._seen[number], -number), default=None)

    def assign(self, basin: int, catalogue: Catalogue) -> Numbered:
        """Number the attractors of a basin. All earlier basins must have been numbered.

        Parameters
        ----------
        basin : int
        catalogue : tuple of Attractor
            The basin's own catalogue.

        Returns
        -------
        Numbered
        """
        oscillator = self.job.oscillator_of(basin)
        attractors = list(catalogue)
        number_of: dict[int, int] = {}
        for neighbour in self._known(basin):
            known = [each for each in zip(*neighbour, strict=True) if each[1] not in number_of.values()]
            _continue(oscillator, known, attractors, number_of)
            _match(oscillator, known, attractors, number_of)
        for index, attractor in enumerate(attractors):
            if index not in number_of:
                motion = motion_of(attractor)
                earlier = self._earlier(motion, number_of)
                number_of[index] = self.table.append(motion) if earlier is None else earlier
        self._seen |= dict.fromkeys(number_of.values(), basin)
        numbered = Numbered(tuple(attractors), [number_of[index] for index in range(len(attractors))])
        self._keep(basin, numbered)
        if basin in self._earlier_twin.values():
            self._twins[basin] = self._recent[basin]
        return numbered


def _earlier_twins(job: BasinJob) -> dict[int, int]:
    """Basins of a machine that an earlier basin has as well, since a phase came around, and the first of those."""
    if not any(is_phase(name) for axis in job.axes for name in axis.columns):
        return {}
    first: dict[tuple[float, ...], int] = {}
    twins = {}
    for basin in range(job.basins):
        changes = changes_at(job.axes, job.place_of(basin))
        machine = tuple(
            round(value % 1.0, _PHASE_DIGITS) % 1.0 if is_phase(name) else value for name, value in changes.items()
        )
        if first.setdefault(machine, basin) != basin:
            twins[basin] = first[machine]
    return twins


def _thinned(attractor: Attractor) -> Attractor:
    """Attractor, with only enough points to locate it if it is chaotic. A row of basins is kept in memory."""
    if not attractor.is_chaotic:
        return attractor
    return attractor._replace(time=attractor.time[:_POINTS_KEPT], velocity=attractor.velocity[:_POINTS_KEPT])


def _continue(
    oscillator: Oscillator, known: list[tuple[Attractor, int]], attractors: list[Attractor], number_of: dict[int, int]
) -> None:
    """Give each attractor the number of the one that Newton's method continues to it. Add those that are missing."""
    for old, number in known:
        continued = continue_attractor(oscillator, old)
        if continued is None:
            continue
        same = [
            index for index, attractor in enumerate(attractors)
            if motion_of(attractor) == motion_of(continued)
            and attractor_distance(oscillator, attractor, continued) < _SAME_ORBIT
        ]  # fmt: skip
        if not same:
            same = [len(attractors)]
            attractors.append(continued)
        number_of.setdefault(same[0], number)


def _match(
    oscillator: Oscillator, known: list[tuple[Attractor, int]], attractors: list[Attractor], number_of: dict[int, int]
) -> None:
    """Give attractors the numbers of the closest unmatched ones of the same kind and itinerary."""
    pairs = sorted(
        (attractor_distance(oscillator, attractor, old), number, index)
        for old, number in known if number not in number_of.values()
        for index, attractor in enumerate(attractors)
        if index not in number_of and motion_of(attractor) == motion_of(old)
    )  # fmt: skip
    for _, number, index in pairs:
        if index not in number_of and number not in number_of.values():
            number_of[index] = number
