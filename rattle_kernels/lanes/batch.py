"""The points of a run, and its rules."""

from typing import NamedTuple

import numpy as np


class Batch(NamedTuple):
    """Points, which become where they land, and what is counted on the way; arrays of shape (n,)."""

    t: np.ndarray
    v: np.ndarray
    outcome: np.ndarray
    lower_impacts: np.ndarray


class Rules(NamedTuple):
    """How often P is applied, and when a point is captured or locked."""

    applications: float
    capture_bound: float
    lock_tolerance: float


class LaneRun(NamedTuple):
    """What a run took: applications of P, and flights and contacts on the careful path."""

    applications: int
    careful_flights: int
