"""How fast tangent vectors grow along trajectories of P: their largest Lyapunov exponent, in lanes.

A tangent vector is carried along by DP and rescaled after every impact; the exponent is the mean growth of its
logarithm per forcing period (Benettin et al. 1980). Many trajectories are followed for some hundred impacts each in
place of one for many thousands: they are independent, so that their scatter is the error of the mean, and they keep all
lanes busy. The flights are those of `impact_lanes`, to the bit.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.apply import LOWER, RETURNED, UPPER, Contact
from rattle_kernels.impact_map.chatter import is_captured
from rattle_kernels.impact_map.jacobian import flight_jacobian, stay_jacobian
from rattle_kernels.lanes.contact import guess_stays, refine_stays, stay_carefully
from rattle_kernels.lanes.flight import (
    DROPS,
    DURATION,
    END_PHASE,
    END_VELOCITY,
    FLIGHT_FIELDS,
    LANES,
    PHASE,
    VELOCITY,
    fly_carefully,
    guess_durations,
    refine_durations,
)
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.model.contact import Stay, slow_part
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import inlined, lane_kernel

# Tangent vectors turn into the growing direction within as many impacts, whatever it is: by e^-20 or so in chaos.
_ALIGNING = 64


class Growth(NamedTuple):
    """How tangent vectors grew along some trajectories, each of one number of impacts; arrays of shape (n,).

    ``growth`` is the change of the vector's logarithm, ``elapsed`` the time (forcing periods) that it took; ``t``,
    ``v`` are the departures after the last impact. All of them are NaN where contact has become permanent on the way.
    """

    growth: np.ndarray
    elapsed: np.ndarray
    t: np.ndarray
    v: np.ndarray

    def of(self, chosen: np.ndarray) -> "Growth":
        """Some of the trajectories, by a mask."""
        return Growth(*(field[chosen] for field in self))

    @property
    def exponent(self) -> float:
        """Largest Lyapunov exponent per forcing period, of all of them."""
        return float(self.growth.sum() / self.elapsed.sum())

    @property
    def error(self) -> float:
        """Standard error of the exponent, by the scatter over trajectories; infinite where there is but one."""
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
def _fly(oscillator, tables, lanes, corners, tangents, elapsed, left):
    """A flight of every lane; the tangent vectors and the time of those that go on."""
    guess_durations(lanes, corners, tables, 2.0 * oscillator.half_backlash)
    if refine_durations(lanes, oscillator.damping, oscillator.eccentricity) > 0:
        fly_carefully(lanes, oscillator)
    for i in range(left.size):
        if left[i] > 0:
            phase, duration = lanes[PHASE + i], lanes[DURATION + i]
            contact = Contact(UPPER, phase + duration, duration, -lanes[END_VELOCITY + i], True)
            _turn(tangents, i, flight_jacobian(oscillator, phase, lanes[VELOCITY + i], contact))
            elapsed[i] += duration
    _begin_at_the_end(lanes)


@inlined
def _stay(oscillator, tables, lanes, corners, tangents, elapsed, left):
    """The stay in contact of every lane after it."""
    guess_stays(lanes, corners, tables)
    if refine_stays(lanes, oscillator.damping, slow_part(oscillator)) > 0:
        stay_carefully(lanes, oscillator)
    for i in range(left.size):
        if left[i] > 0:
            velocity, duration = lanes[VELOCITY + i], lanes[DURATION + i]
            side = LOWER if velocity > 0.0 else UPPER
            stay = Stay(duration, abs(lanes[END_VELOCITY + i]), RETURNED)
            _turn(tangents, i, stay_jacobian(oscillator, side, lanes[PHASE + i], abs(velocity), stay))
            elapsed[i] += duration
    _begin_at_the_end(lanes)


@inlined
def _begin_at_the_end(lanes):
    for i in range(LANES):
        lanes[PHASE + i] = lanes[END_PHASE + i]
        lanes[VELOCITY + i] = lanes[END_VELOCITY + i]


@inlined
def _idle(lanes, lane, speed_scale):
    """Fly at a speed at which a lane is never unsure."""
    lanes[PHASE + lane], lanes[VELOCITY + lane], lanes[DROPS + lane] = 0.0, -1e6 * speed_scale, 0.0


@lane_kernel
def _grow(oscillator, tables, impacts, t, v, growth, elapsed):
    """Run the trajectories of one crowd, at most LANES; they become where they end."""
    lanes, corners = np.zeros(FLIGHT_FIELDS * LANES), np.zeros(LANES, np.int64)
    tangents, left = np.zeros((2, t.size)), np.full(t.size, impacts + _ALIGNING)
    stiff = math.isfinite(oscillator.stiffness)
    for i in range(LANES):
        _idle(lanes, i, tables.speed_scale)
    for i in range(t.size):
        lanes[PHASE + i], lanes[VELOCITY + i] = t[i] - math.floor(t[i]), -v[i]
        tangents[0, i] = 1.0
    flying = t.size
    while flying > 0:
        _fly(oscillator, tables, lanes, corners, tangents, elapsed, left)
        if stiff:
            _stay(oscillator, tables, lanes, corners, tangents, elapsed, left)
        for i in range(t.size):
            found = lanes[PHASE + i] == lanes[PHASE + i]  # NaN where a root-finder gave up: that lane is done
            if left[i] == 0 or (found and lanes[DROPS + i] != 0.0):
                continue
            left[i] -= 1
            t[i], v[i] = lanes[PHASE + i], -lanes[VELOCITY + i]
            norm = math.hypot(tangents[0, i], tangents[1, i] / tables.speed_scale)
            growth[i] += math.log(norm)
            tangents[0, i], tangents[1, i] = tangents[0, i] / norm, tangents[1, i] / norm
            if left[i] == impacts:
                growth[i] = elapsed[i] = 0.0
            if not (found and v[i] > 0.0) or is_captured(oscillator, tables.capture_bound, t[i], v[i]):
                left[i] = 0
                t[i] = v[i] = growth[i] = elapsed[i] = math.nan
            if left[i] == 0:
                _idle(lanes, i, tables.speed_scale)
                flying -= 1


def tangent_growth(oscillator: Oscillator, t: np.ndarray, v: np.ndarray, impacts: int) -> Growth:
    """How tangent vectors grow along trajectories.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : ndarray of float64, shape (n,)
        Phases and speeds of departures from +beta.
    impacts : int
        Length of each run, after 64 impacts in which the vectors align.

    Returns
    -------
    Growth
    """
    tables, ends = lane_tables(oscillator), (t.copy(), v.copy())
    sums = np.zeros(t.size), np.zeros(t.size)
    for first in range(0, t.size, LANES):
        crowd = slice(first, first + LANES)
        _grow(oscillator, tables, impacts, *(field[crowd] for field in (*ends, *sums)))
    return Growth(*sums, *ends)
