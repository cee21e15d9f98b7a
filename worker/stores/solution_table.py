"""What is known of the solutions of all panels: what each is, by its number, and what it is like in each panel."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rattle_kernels import Attractor, AttractorKind
from worker.jobs.basin_job import BasinJob


class Motion(NamedTuple):
    """What makes two solutions of neighbouring panels possibly the same: kind, and P(m, n+, n-)."""

    kind: AttractorKind
    forcing_periods: int
    upper_contacts: int
    lower_contacts: int

    @property
    def name(self) -> str:
        """As an attractor is named."""
        return Attractor(*self, np.nan, np.nan, np.empty(0), np.empty(0)).name


def motion_of(attractor: Attractor) -> Motion:
    """Kind and itinerary of an attractor."""
    return Motion(*attractor[:4])


@dataclass
class SolutionTable:
    """Solutions by number, and per panel their share, Lyapunov exponent, its error and mean life (panels, solutions).

    A share is NaN where a panel has no such solution, and in the whole row of a panel that is not complete.
    """

    motions: list[Motion]
    share: np.ndarray
    exponent: np.ndarray
    error: np.ndarray
    mean_life: np.ndarray

    @classmethod
    def empty(cls, job: BasinJob) -> "SolutionTable":
        """Table of a job that has not begun."""
        return cls([], *(np.empty((job.panels, 0)) for _ in range(4)))

    @property
    def columns(self) -> list[np.ndarray]:
        """What solutions are like in each panel, in the order of `layout.MEASURED`."""
        return [self.share, self.exponent, self.error, self.mean_life]

    def _replace(self, columns: list[np.ndarray]) -> None:
        self.share, self.exponent, self.error, self.mean_life = columns

    @property
    def complete(self) -> np.ndarray:
        """Whether each panel is complete: permanent contact, number 0, is a solution of every one."""
        if not self.motions:
            return np.zeros(self.share.shape[0], bool)
        return np.isfinite(self.share[:, 0])

    def numbers_in(self, panel: int) -> list[int]:
        """Solutions that a complete panel has."""
        return np.flatnonzero(np.isfinite(self.share[panel])).tolist()

    def last_seen(self) -> dict[int, int]:
        """The last complete panel that has each solution."""
        panels, numbers = np.nonzero(np.isfinite(self.share))
        return dict(zip(numbers.tolist(), panels.tolist(), strict=True))

    def append(self, motion: Motion) -> int:
        """Number of a solution that is new."""
        self.motions.append(motion)
        self._replace([np.pad(column, ((0, 0), (0, 1)), constant_values=np.nan) for column in self.columns])
        return len(self.motions) - 1

    def forget_after(self, panels: int) -> None:
        """Keep the rows of the first panels alone, and the solutions that these have."""
        for column in self.columns:
            column[panels:] = np.nan
        known = np.flatnonzero(np.isfinite(self.share).any(axis=0))
        solutions = int(known[-1]) + 1 if known.size else 0
        del self.motions[solutions:]
        self._replace([column[:, :solutions] for column in self.columns])

    def enter(self, panel: int, numbers: list[int], attractors: tuple[Attractor, ...], shares: np.ndarray) -> None:
        """Fill the row of a panel."""
        self.share[panel, numbers] = shares
        self.exponent[panel, numbers] = [attractor.lyapunov_exponent for attractor in attractors]
        self.error[panel, numbers] = [attractor.lyapunov_error for attractor in attractors]
        self.mean_life[panel, numbers] = [attractor.mean_life for attractor in attractors]
