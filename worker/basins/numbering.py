"""One number for one solution from basin to basin of a sweep.

Every basin finds its own catalogue, whatever its neighbours find. Then, in the order of basins:

1. Each periodic attractor of a neighbour is continued by Newton's method to the panel's parameters. Where that ends on
   an attractor of the basin, the two are one solution; where it ends on one that the panel's catalogue lacks (its basin
   holds no cell of the grid), that is added, with a share of 0.
2. What is left is matched by kind and itinerary, the closest first.
3. What is left then was not there before. It takes the number of a solution of its kind and itinerary that the basin
   does not have yet, the one that was there last: across a sweep, its itinerary names a motion. Where there is none, it
   takes the next number.

Neighbours are the basin before along the last swept parameter and then, for what that one does not have, the basin
before along the first. So numbers follow from the catalogues alone, whenever those were found.
"""

from collections import OrderedDict
from collections.abc import Callable
from typing import NamedTuple

from rattle_kernels import Attractor, Oscillator, attractor_distance, continue_attractor
from worker.jobs.basin_job import BasinJob
from worker.stores.solution_table import Motion, SolutionTable, motion_of

# Newton's method ends within 1e-11: closer than this is the same orbit.
_SAME_ORBIT = 1e-6
_POINTS_KEPT = 256

Catalogue = tuple[Attractor, ...]


class Numbered(NamedTuple):
    """Attractors of a basin, those of its own catalogue first, and the number of each."""

    attractors: Catalogue
    numbers: list[int]


class Numbering:
    """Gives solutions their numbers, basin by basin, in order.

    Parameters
    ----------
    job : BasinJob
    table : SolutionTable
        Of the basins that have their numbers already; new solutions are appended to it.
    read : callable
        Numbered attractors of a basin that had its numbers before this run.
    """

    def __init__(self, job: BasinJob, table: SolutionTable, read: Callable[[int], Numbered]) -> None:
        self.job, self.table, self._read = job, table, read
        # The basin before along the first parameter is a whole row of basins ago.
        self._kept = 1 if len(job.vary) < 2 else job.sweep_shape[-1]
        self._recent: OrderedDict[int, Numbered] = OrderedDict()
        self._seen = table.last_seen()

    def _neighbours(self, basin: int) -> list[int]:
        place, row = self.job.place_of(basin), self.job.sweep_shape[-1] if self.job.vary else 1
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

    def _earlier(self, motion: Motion, number_of: dict[int, int]) -> int | None:
        """Number of a motion that the basin does not have yet: of several, the one that was there last."""
        free = [
            number
            for number, listed in enumerate(self.table.motions)
            if listed == motion and number not in number_of.values()
        ]
        return max(free, key=lambda number: (self._seen[number], -number), default=None)

    def assign(self, basin: int, catalogue: Catalogue) -> Numbered:
        """Number the attractors of a basin: the next one after all that have been numbered.

        Parameters
        ----------
        basin : int
        catalogue : tuple of Attractor
            What the basin has found by itself.

        Returns
        -------
        Numbered
        """
        oscillator = self.job.oscillator_of(basin)
        attractors = list(catalogue)
        number_of: dict[int, int] = {}
        for neighbour in self._neighbours(basin):
            known = [each for each in zip(*self._of(neighbour), strict=True) if each[1] not in number_of.values()]
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
        return numbered


def _thinned(attractor: Attractor) -> Attractor:
    """Attractor with as many points of a chaotic one as tell where it is: a row of basins is kept in memory."""
    if not attractor.wanders:
        return attractor
    return attractor._replace(time=attractor.time[:_POINTS_KEPT], velocity=attractor.velocity[:_POINTS_KEPT])


def _continue(
    oscillator: Oscillator, known: list[tuple[Attractor, int]], attractors: list[Attractor], number_of: dict[int, int]
) -> None:
    """Give attractors the numbers of those that Newton's method leads to them; add what is not there yet."""
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
    """Give attractors the numbers of the closest of their kind and itinerary that have not found theirs."""
    pairs = sorted(
        (attractor_distance(oscillator, attractor, old), number, index)
        for old, number in known if number not in number_of.values()
        for index, attractor in enumerate(attractors)
        if index not in number_of and motion_of(attractor) == motion_of(old)
    )  # fmt: skip
    for _, number, index in pairs:
        if index not in number_of and number not in number_of.values():
            number_of[index] = number
