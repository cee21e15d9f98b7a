"""Attractors and chaotic transients: permanent contact, periodic orbits and chaos."""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from rattle_kernels.orbits.periodic_orbit import orbit_name

ENSEMBLE, SHORTEST_RUN = 64, 16_384
"""Trajectories from which a mean life is counted, and the least impacts of each."""


class AttractorKind(IntEnum):
    """Kind of a motion. Codes are append-only."""

    PERIODIC = 1
    CHAOTIC = 2
    PERMANENT_CONTACT = 3
    UNDECIDED = 4
    CHAOTIC_TRANSIENT = 5


class Attractor(NamedTuple):
    """A motion that trajectories end in, or a chaotic transient that they follow for very long before.

    ``time`` and ``velocity`` (shape (points,)) are its departures from +beta: one turn of a periodic orbit, starting
    with the slowest; some thousand for chaos; none for permanent contact. Exponents are per forcing period, NaN if not
    defined. ``lyapunov_error`` is the standard error (0 for a periodic orbit, whose exponent comes from its
    multipliers). ``mean_life`` is the mean number of impacts until a trajectory leaves a chaotic transient; NaN if none
    was seen to leave. ``ends`` says what a chaotic transient ends in: the place of each such motion in the catalogue,
    or in a result its number, and the share of the ensemble that ended there. The rest was still on the transient after
    half a million impacts.
    """

    kind: AttractorKind
    forcing_periods: int
    upper_contacts: int
    lower_contacts: int
    lyapunov_exponent: float
    lyapunov_error: float
    time: np.ndarray
    velocity: np.ndarray
    mean_life: float = np.nan
    ends: tuple[tuple[int, float], ...] = ()

    @property
    def name(self) -> str:
        """``P(m, n+, n-)`` (Sec. 4), starred if it rests; chaotic, chaotic transient, permanent contact, undecided."""
        if self.kind == AttractorKind.PERIODIC:
            return orbit_name(self.forcing_periods, self.upper_contacts, self.lower_contacts, rests=self.rests)
        return self.kind.name.lower().replace("_", " ")

    @property
    def rests(self) -> bool:
        """Whether it is a periodic orbit that comes to rest in every turn: no other has the exponent -infinity."""
        return self.lyapunov_exponent == -math.inf

    @property
    def mean_life_error(self) -> float:
        """Standard error of the mean life at most, in impacts; NaN if there is none.

        The mean life is T = -n / ln(1 - p), where the part p of an ensemble of N trajectories has left after n impacts.
        p has the variance p (1 - p) / N, so that T has the relative error sqrt((e^x - 1) / N) / x with x = n / T. It
        falls with x up to 1.6, and no transient is listed that half of the ensemble has left (x = ln 2). So the
        shortest n gives the largest error.
        """
        x = SHORTEST_RUN / self.mean_life
        return float(self.mean_life * np.sqrt(np.expm1(x) / ENSEMBLE) / x)

    @property
    def label(self) -> str:
        """The name and, for a chaotic transient, its mean life with its error."""
        if np.isnan(self.mean_life):
            return self.name
        return f"{self.name} of some {self.mean_life:.1g} ± {self.mean_life_error:.1g} impacts"

    @property
    def is_chaotic(self) -> bool:
        """Whether it is chaos, as an attractor or as a transient."""
        return self.kind in (AttractorKind.CHAOTIC, AttractorKind.CHAOTIC_TRANSIENT)


def _without_points(kind: AttractorKind) -> Attractor:
    return Attractor(kind, 0, 0, 0, np.nan, np.nan, np.empty(0), np.empty(0))


PERMANENT_CONTACT_ATTRACTOR = _without_points(AttractorKind.PERMANENT_CONTACT)
UNDECIDED_ATTRACTOR = _without_points(AttractorKind.UNDECIDED)


def with_undecided(attractors: tuple[Attractor, ...]) -> tuple[Attractor, ...]:
    """Catalogue that holds undecided motions, as its last one if it has none."""
    known = any(attractor.kind == AttractorKind.UNDECIDED for attractor in attractors)
    return attractors if known else (*attractors, UNDECIDED_ATTRACTOR)
