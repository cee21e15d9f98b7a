"""How fast tangent vectors grow along trajectories of P: their largest Lyapunov exponent, in lanes.

DP carries a tangent vector along, and it is rescaled after every impact. The exponent is the mean growth of its
logarithm per forcing period (Benettin et al. 1980). Many trajectories are followed for some hundred impacts each,
instead of one for many thousands. They are independent, so their scatter gives the error of the mean, and they keep all
lanes busy. The flights are those of `run`, to the bit.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.chatter import is_captured
from rattle_kernels.impact_map.flights import LOWER, UPPER, FlightEnd
from rattle_kernels.impact_map.variations import contact_jacobian, flight_jacobian
from rattle_kernels.lanes.advance import begin_at_the_end, depart, fly, idle, stay
from rattle_kernels.lanes.lane_fields import DROPS, DURATION, END_VELOCITY, FLIGHT_FIELDS, LANES, PHASE, VELOCITY
from rattle_kernels.lanes.loose_flight import rest_time
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.model.contact import slow_part
from rattle_kernels.model.contact_end import Contact
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import inlined, lane_kernel

# Within this many impacts tangent vectors turn into the growing direction; in chaos what is left is e^-20 or so.
_ALIGNING = 64


class TangentGrowth(NamedTuple):
    """How tangent vectors grew along some trajectories, all of one number of impacts; arrays of shape (n,).

    ``growth`` is the change of the logarithm of the vector's length, ``elapsed`` the time (forcing periods) that it
    took. ``t``, ``v`` are the departures after the last impact. All are NaN where contact became permanent on the way.
    Of a loose gear it is the growth between rests: a rest forgets the vector, and another begins.
    """

    growth: np.ndarray
    elapsed: np.ndarray
    t: np.ndarray
    v: np.ndarray

    def of(self, chosen: np.ndarray) -> "TangentGrowth":
        """The trajectories that a mask chooses."""
        return TangentGrowth(*(field[chosen] for field in self))

    @property
    def exponent(self) -> float:
        """Largest Lyapunov exponent per forcing period, over all of them."""
        return float(self.growth.sum() / self.elapsed.sum())

    @property
    def error(self) -> float:
        """Standard error of the exponent, from the scatter over trajectories; infinite for a single one."""
        if self.growth.size < 2:
            return math.inf
        scatter = (self.growth - self.exponent * self.elapsed) / self.elapsed.mean()
        return float(scatter.std(ddof=1) / math.sqrt(scatter.size))


@inlined
def _turn(tangents, lane, jacobian):
    dt, dw = tangents[0, lane], tangents[1, lane]
    tangents[0, lane] = jacobian.tt * dt + jacobian.tv * dw
    tangents[1, lane] = jacobian.vt * dt + jacobian.vv * dw


@inlined
def _turn_by_flights(lanes, oscillator, tangents, elapsed, left):
    """Carry the tangent vectors of the lanes that go on along their flights and impacts, and count the time."""
    for i in range(left.size):
        if left[i] > 0:
            phase, duration = lanes[PHASE + i], lanes[DURATION + i]
            arrives = -lanes[END_VELOCITY + i] / oscillator.restitution
            end = FlightEnd(UPPER, phase + duration, duration, arrives, True)
            _turn(tangents, i, flight_jacobian(oscillator, phase, lanes[VELOCITY + i], end))
            tangents[1, i] *= oscillator.restitution
            if rest_time(oscillator, lanes, i) > 0.0:  # what it was is forgotten: a new vector
                tangents[0, i], tangents[1, i] = 1.0, 0.0
            elapsed[i] += duration


@inlined
def _turn_by_contacts(lanes, oscillator, tangents, elapsed, left):
    """Carry the tangent vectors of the lanes that go on through their contacts, and count the time."""
    for i in range(left.size):
        if left[i] > 0:
            velocity, duration = lanes[VELOCITY + i], lanes[DURATION + i]
            side = LOWER if velocity > 0.0 else UPPER
            contact = Contact(duration, abs(lanes[END_VELOCITY + i]), OUTCOME_RETURNED)
            _turn(tangents, i, contact_jacobian(oscillator, side, lanes[PHASE + i], abs(velocity), contact))
            elapsed[i] += duration


@lane_kernel
def _grow(oscillator, tables, impacts, t, v, growth, elapsed):
    """Follow at most LANES trajectories; t and v become where they end."""
    lanes, corners = np.zeros(FLIGHT_FIELDS * LANES), np.zeros(LANES, np.int64)
    tangents, left = np.zeros((2, t.size)), np.full(t.size, impacts + _ALIGNING)
    stiff, slow = math.isfinite(oscillator.stiffness), slow_part(oscillator)
    for i in range(t.size):
        depart(lanes, i, t[i], v[i])
        tangents[0, i] = 1.0
    flying = t.size
    while flying > 0:
        for i in range(LANES):
            if i >= t.size or left[i] == 0:
                idle(lanes, i, tables.largest_grazing_speed)
        fly(lanes, corners, oscillator, tables)
        _turn_by_flights(lanes, oscillator, tangents, elapsed, left)
        begin_at_the_end(lanes)
        if stiff:
            stay(lanes, corners, oscillator, tables, slow)
            _turn_by_contacts(lanes, oscillator, tangents, elapsed, left)
            begin_at_the_end(lanes)
        for i in range(t.size):
            found = lanes[PHASE + i] == lanes[PHASE + i]  # NaN where a root-finder gave up: that lane is done
            if left[i] == 0 or (found and lanes[DROPS + i] != 0.0):
                continue
            left[i] -= 1
            t[i], v[i] = lanes[PHASE + i], -lanes[VELOCITY + i]
            norm = math.hypot(tangents[0, i], tangents[1, i] / tables.largest_grazing_speed)
            growth[i] += math.log(norm)
            tangents[0, i], tangents[1, i] = tangents[0, i] / norm, tangents[1, i] / norm
            if left[i] == impacts:
                growth[i] = elapsed[i] = 0.0
            if not (found and v[i] > 0.0) or is_captured(oscillator, tables.capture_bound, t[i], v[i]):
                left[i] = 0
                t[i] = v[i] = growth[i] = elapsed[i] = math.nan
            if left[i] == 0:
                flying -= 1


def tangent_growth(
    oscillator: Oscillator, t: np.typing.ArrayLike, v: np.typing.ArrayLike, impacts: int
) -> TangentGrowth:
    """Growth of tangent vectors along trajectories: their largest Lyapunov exponent, and its error.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    t, v : array_like, shape (n,)
        Phases (forcing periods) and speeds of departures from +beta.
    impacts : int
        Impacts over which growth is measured, at least 1, after 64 impacts in which the vectors align.

    Returns
    -------
    TangentGrowth
        NaN also where a point is no departure: not finite, or without a positive speed.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If ``impacts`` is below 1.

    Examples
    --------
    >>> chaos = tangent_growth(Oscillator(), [0.553, 0.554, 0.555], [4.703, 4.703, 4.703], 512)
    >>> chaos.exponent > 0.1
    True
    """
    checked = check_oscillator(oscillator)
    if impacts < 1:
        raise ValueError(f"impacts must be at least 1, not {impacts}")
    phase, speed = np.asarray(t, np.float64), np.asarray(v, np.float64)
    departs = np.isfinite(phase) & np.isfinite(speed) & (speed > 0.0)
    tables, ends = lane_tables(checked), (phase[departs], speed[departs])
    sums = np.zeros(ends[0].size), np.zeros(ends[0].size)
    for first in range(0, ends[0].size, LANES):
        batch = slice(first, first + LANES)
        _grow(checked, tables, impacts, *(field[batch] for field in (*ends, *sums)))
    grown = TangentGrowth(*(np.full(phase.shape, np.nan) for _ in range(4)))
    for whole, part in zip(grown, (*sums, *ends), strict=True):
        whole[departs] = part
    return grown
