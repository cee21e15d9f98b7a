"""The solutions of all basins: the motion of each number, and its properties in each basin."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rattle_kernels import Attractor, AttractorKind
from worker.jobs.basin_job import BasinJob
from worker.jobs.sample import Sample

WITHOUT_POINTS = AttractorKind.PERMANENT_CONTACT, AttractorKind.UNDECIDED
"""Kinds of motions that have no departures to list."""


class Motion(NamedTuple):
    """Kind, P(m, n+, n-) and star. Solutions of neighbouring basins can only be the same if these are equal."""

    kind: AttractorKind
    forcing_periods: int
    upper_contacts: int
    lower_contacts: int
    rests: bool

    @property
    def name(self) -> str:
        """Name, in the form of an attractor's."""
        exponent = -np.inf if self.rests else np.nan
        return Attractor(*self[:4], exponent, np.nan, np.empty(0), np.empty(0)).name


def motion_of(attractor: Attractor) -> Motion:
    """Kind and itinerary of an attractor, and whether it rests."""
    return Motion(*attractor[:4], attractor.rests)


def share_error(counts: np.ndarray, points: int) -> np.ndarray:
    """Standard errors of shares of points.

    Of one set of points they are those of independent points: the standard deviation of Laplace's rule of succession,
    of what a share may be once so many points are known. The binomial law, which it follows elsewhere, would give no
    error to the shares 0 and 1. Of several sets of the same size it is the standard error of the mean of their shares;
    where all sets agree, their scatter says nothing, and Laplace's stays.

    Parameters
    ----------
    counts : ndarray of int, shape (sets, solutions)
        Points of each set that end in each solution.
    points : int
        Of all sets.

    Returns
    -------
    ndarray of float64, shape (solutions,)

    Examples
    --------
    >>> share_error(np.array([[0, 100], [0, 100]]), 200).round(4)
    array([0.0049, 0.0049])
    >>> share_error(np.array([[20, 80], [22, 78]]), 200).round(4)
    array([0.01, 0.01])
    """
    sets = counts.shape[0]
    share = counts.sum(axis=0) / points
    likely = (share * points + 1.0) / (points + 2.0)
    laplace: np.ndarray = (likely * (1.0 - likely) / (points + 3.0)) ** 0.5
    if sets == 1:
        return laplace
    scatter = np.std(counts / (points / sets), axis=0, ddof=1) / sets**0.5
    return np.where(np.ptp(counts, axis=0) > 0, scatter, laplace)


def shares_of_sets(solution: np.ndarray, numbers: Sequence[int], sample: Sample | None) -> np.ndarray | None:
    """Share of each motion in each scrambled set of a sample; None where there are not several.

    Parameters
    ----------
    solution : ndarray of int, shape (points,)
        Motion of each point.
    numbers : sequence of int
        The motions.
    sample : Sample, optional

    Returns
    -------
    ndarray of float64, shape (sets, motions), or None
    """
    if sample is None or sample.scramblings == 1:
        return None
    of_set = sample.set_of(0, solution.size)
    counts = [np.bincount(of_set[solution == number], minlength=sample.scramblings) for number in numbers]
    return np.stack(counts, axis=1) * (sample.scramblings / sample.points)


def ends_in(row: np.ndarray) -> tuple[tuple[int, float], ...]:
    """What a solution ends in, from its row of `layout.ENDS`: numbers of solutions, and shares."""
    return tuple((number, float(row[number])) for number in np.flatnonzero(np.isfinite(row)).tolist())


@dataclass
class SolutionTable:
    """Solutions by number, and per basin their share, Lyapunov exponent, its error and mean life (basins, solutions).

    A share is NaN where a basin has no such solution, and in the whole row of a basin that is not complete; its error
    is NaN for cells, too.
    """

    motions: list[Motion]
    share: np.ndarray
    exponent: np.ndarray
    error: np.ndarray
    mean_life: np.ndarray
    share_error: np.ndarray

    @classmethod
    def empty(cls, job: BasinJob) -> "SolutionTable":
        """Table of a job that has not begun."""
        return cls([], *(np.empty((job.basins, 0)) for _ in range(5)))

    @property
    def columns(self) -> list[np.ndarray]:
        """Properties of solutions in each basin, in the order of `layout.MEASURED`; the errors of shares last."""
        return [self.share, self.exponent, self.error, self.mean_life, self.share_error]

    def _replace(self, columns: list[np.ndarray]) -> None:
        self.share, self.exponent, self.error, self.mean_life, self.share_error = columns

    @property
    def complete(self) -> np.ndarray:
        """Whether each basin is complete: permanent contact, number 0, is a solution of every one."""
        if not self.motions:
            return np.zeros(self.share.shape[0], bool)
        return np.isfinite(self.share[:, 0])

    def numbers_in(self, basin: int) -> list[int]:
        """Solutions that a complete basin has."""
        return np.flatnonzero(np.isfinite(self.share[basin])).tolist()

    def last_seen(self) -> dict[int, int]:
        """The last complete basin that has each solution."""
        basins, numbers = np.nonzero(np.isfinite(self.share))
        return dict(zip(numbers.tolist(), basins.tolist(), strict=True))

    def append(self, motion: Motion) -> int:
        """Add a new solution, and return its number."""
        self.motions.append(motion)
        self._replace([np.pad(column, ((0, 0), (0, 1)), constant_values=np.nan) for column in self.columns])
        return len(self.motions) - 1

    def forget_after(self, basins: int) -> None:
        """Keep only the rows of the first basins, and only their solutions."""
        for column in self.columns:
            column[basins:] = np.nan
        known = np.flatnonzero(np.isfinite(self.share).any(axis=0))
        solutions = int(known[-1]) + 1 if known.size else 0
        del self.motions[solutions:]
        self._replace([column[:, :solutions] for column in self.columns])

    def enter(
        self, basin: int, numbers: list[int], attractors: tuple[Attractor, ...], shares: np.ndarray,
        errors: np.ndarray | float = np.nan,
    ) -> None:  # fmt: skip
        """Fill the row of a basin."""
        self.share[basin, numbers] = shares
        self.share_error[basin, numbers] = errors
        self.exponent[basin, numbers] = [attractor.lyapunov_exponent for attractor in attractors]
        self.error[basin, numbers] = [attractor.lyapunov_error for attractor in attractors]
        self.mean_life[basin, numbers] = [attractor.mean_life for attractor in attractors]
