"""A branch of periodic orbits in one parameter, and why it ends."""

from enum import StrEnum
from typing import NamedTuple

import numpy as np

from rattle_kernels.orbits.bifurcation_point import SpecialPoint


class BranchEnd(StrEnum):
    """Why a branch of orbits ends."""

    START = "the orbit it began with"
    BOUND = "a bound of the parameter"
    CLOSED = "back where it began"
    GRAZING = "the orbit grazes -beta"
    UPPER_GRAZING = "the orbit grazes +beta from below"
    RELEASE = "its rest has shrunk to nothing: release"
    HELD = "the gear is not released there any more: a(t) keeps its sign"
    RENAMED = "its rest begins a contact later or earlier: the motion goes on under another name"
    CONTACT_LOSS = "a stay beyond +beta touches it"
    HALVED = "the orbit is one of half the period, gone through twice"
    DOMAIN = "the edge of the domain (Eq. 8)"
    POINTS = "as many points as were asked for"
    STALLED = "no step succeeds"


class End(NamedTuple):
    """Why a branch ends, the parameter's value there, and a message that states both."""

    reason: BranchEnd
    value: float
    message: str


class Branch(NamedTuple):
    """A branch of orbits P(m, n+, .), in order along it.

    ``values`` (shape (n,)) are the parameter's values. ``t``, ``v``, ``grazing_margin`` and ``lower_speed`` (shape (n,
    upper_contacts)) are as in `FoundOrbit`, in order of time from the same departure on. ``trace`` is the trace of DP^p
    and ``area`` its determinant e^{-delta m}; both are 0 where the orbits rest. ``special_points`` are in order along
    the branch. ``ends`` belong to its first and its last point.
    """

    parameter: str
    forcing_periods: int
    upper_contacts: int
    values: np.ndarray
    t: np.ndarray
    v: np.ndarray
    grazing_margin: np.ndarray
    lower_speed: np.ndarray
    trace: np.ndarray
    area: np.ndarray
    special_points: tuple[SpecialPoint, ...]
    ends: tuple[End, End]

    @property
    def multipliers(self) -> np.ndarray:
        """Eigenvalues of DP^p, complex, shape (n, 2)."""
        root = np.sqrt(self.trace**2 - 4.0 * self.area + 0j)
        large = 0.5 * (self.trace + np.where(self.trace < 0, -root, root))
        return np.column_stack([large, self.area / np.where(large == 0.0, 1.0, large)])

    @property
    def attracts(self) -> np.ndarray:
        """Whether both multipliers lie inside the unit circle, shape (n,)."""
        return np.abs(self.trace) < 1.0 + self.area
