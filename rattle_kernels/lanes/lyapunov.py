"""How fast tangent vectors grow along trajectories of P: their largest Lyapunov exponent, in lanes.

DP carries a tangent vector along, and it is rescaled every few flights. The exponent is the mean growth of its
logarithm per forcing period (Benettin et al. 1980). Many trajectories are followed for some hundred impacts each,
instead of one for many thousands. They are independent, so their scatter gives the error of the mean, and they keep all
lanes busy. The flights are those of `run`, to the bit.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.chatter import is_below, ringing_radian
from rattle_kernels.impact_map.flights import LOWER, UPPER, FlightEnd
from rattle_kernels.impact_map.variations import contact_jacobian, flight_jacobian
from rattle_kernels.lanes.advance import begin_at_the_end, depart, fly, idle, stay
from rattle_kernels.lanes.lane_fields import (
    COSINE,
    DROPS,
    DURATION,
    END_ACCELERATION,
    END_PHASE,
    END_VELOCITY,
    FLIGHT_FIELDS,
    LANES,
    PHASE,
    PHI2,
    SINE,
    VELOCITY,
    count_set,
    lane_buffer,
)
from rattle_kernels.lanes.loose_flight import rest_time
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.model.contact import slow_part
from rattle_kernels.model.contact_end import Contact
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.flight import FOUR_PI, TWO_PI, second_phi
from rattle_kernels.model.harmonics import add_rest_acceleration
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import always_inlined, chosen_by_field, inlined, lane_kernel
from rattle_kernels.numerics.polynomials import second_phi_of_part

_TANGENT_TIME, _TANGENT_SPEED, _GROWTH, _ELAPSED, _LEFT, _EVENT = ((FLIGHT_FIELDS + n) * LANES for n in range(6))
_FIELDS = FLIGHT_FIELDS + 6
_NOTHING, _COUNTED, _ENDED = 0.0, 1.0, 2.0

# Flights between two times that vectors are rescaled. One that grazes stretches them by 1e8 or so, so there is room.
_RESCALED_AFTER = 8

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
def _length(lanes, i, largest_grazing_speed):
    return math.hypot(lanes[_TANGENT_TIME + i], lanes[_TANGENT_SPEED + i] / largest_grazing_speed)


@inlined
def _turn(lanes, i, jacobian):
    dt, dw = lanes[_TANGENT_TIME + i], lanes[_TANGENT_SPEED + i]
    lanes[_TANGENT_TIME + i] = jacobian.tt * dt + jacobian.tv * dw
    lanes[_TANGENT_SPEED + i] = jacobian.vt * dt + jacobian.vv * dw


@inlined
def _turn_loosely(lanes, oscillator, largest_grazing_speed):
    """As `_turn_by_flights`, of a gear that rests between flights."""
    for i in range(LANES):
        before = _length(lanes, i, largest_grazing_speed)
        phase, duration = lanes[PHASE + i], lanes[DURATION + i]
        arrives = -lanes[END_VELOCITY + i] / oscillator.restitution
        end = FlightEnd(UPPER, phase + duration, duration, arrives, True)
        _turn(lanes, i, flight_jacobian(oscillator, phase, lanes[VELOCITY + i], end))
        lanes[_TANGENT_SPEED + i] *= oscillator.restitution
        if rest_time(oscillator, lanes, i) > 0.0:  # what it was is forgotten: a new vector
            lanes[_GROWTH + i] += math.log(before)
            lanes[_TANGENT_TIME + i], lanes[_TANGENT_SPEED + i] = 1.0, 0.0
        lanes[_ELAPSED + i] += duration


@chosen_by_field("arcs", _turn_loosely)
def _turn_by_flights(lanes, oscillator, largest_grazing_speed):
    """Carry every tangent vector along its flight and through the impact, and count the time.

    `variations.flight_jacobian`, of what the flight has left in its lane.
    """
    d, e, harmonics, restitution = (
        oscillator.damping, oscillator.eccentricity, oscillator.harmonics, oscillator.restitution,
    )  # fmt: skip
    long = 0
    for i in range(LANES):
        x = d * lanes[DURATION + i]
        lanes[PHI2 + i] = second_phi_of_part(x)
        long += 1 if x > 1.0 else 0
    if long > 0:
        for i in range(LANES):
            x = d * lanes[DURATION + i]
            lanes[PHI2 + i] = second_phi(x) if x > 1.0 else lanes[PHI2 + i]
    for i in range(LANES):
        tau, w, arrives = lanes[DURATION + i], lanes[VELOCITY + i], -lanes[END_VELOCITY + i] / restitution
        rest = FOUR_PI * d - TWO_PI * e * (TWO_PI * lanes[COSINE + i] + d * lanes[SINE + i])
        leaving = add_rest_acceleration(harmonics, rest, (d, lanes[PHASE + i])) - d * w
        arriving = lanes[END_ACCELERATION + i] - d * arrives
        stretch = tau * (1.0 - d * tau * lanes[PHI2 + i])
        decay = 1.0 - d * stretch
        dt, dw = lanes[_TANGENT_TIME + i], lanes[_TANGENT_SPEED + i]
        later = ((w + stretch * leaving) * dt - stretch * dw) / arrives
        lanes[_TANGENT_TIME + i] = later
        lanes[_TANGENT_SPEED + i] = restitution * (decay * (leaving * dt - dw) - arriving * later)
        lanes[_ELAPSED + i] += tau


@inlined
def _turn_by_contacts(lanes, oscillator):
    """Carry every tangent vector through the contact of its lane, and count the time."""
    for i in range(LANES):
        velocity, duration = lanes[VELOCITY + i], lanes[DURATION + i]
        side = LOWER if velocity > 0.0 else UPPER
        contact = Contact(duration, abs(lanes[END_VELOCITY + i]), OUTCOME_RETURNED)
        _turn(lanes, i, contact_jacobian(oscillator, side, lanes[PHASE + i], abs(velocity), contact))
        lanes[_ELAPSED + i] += duration


@always_inlined
def _note_returns(lanes, capture_bound, radian, impacts):
    """Move every lane to where its next flight begins; return how many have an event.

    An event is the end of the alignment, of the run, or of the motion: a capture, or a root-finder that gave up.
    """
    for i in range(LANES):
        phase, velocity, returns = lanes[END_PHASE + i], lanes[END_VELOCITY + i], lanes[DROPS + i] == 0.0
        left = lanes[_LEFT + i] - (1.0 if returns else 0.0)
        event = _COUNTED if left == impacts else _NOTHING
        event = _COUNTED if left == 0.0 else event
        event = _ENDED if is_below(capture_bound, radian, lanes[END_ACCELERATION + i], -velocity) else event
        event = _ENDED if velocity == 0.0 else event  # a contact that does not end
        event = event if returns else _NOTHING
        lanes[_EVENT + i] = event if phase == phase else _ENDED  # NaN: a root-finder gave up
        lanes[_LEFT + i] = left
        lanes[PHASE + i], lanes[VELOCITY + i] = phase, velocity
    return count_set(lanes, _EVENT)


@inlined
def _rescale(lanes, largest_grazing_speed):
    """Make every tangent vector one of length 1, and count its logarithm."""
    for i in range(LANES):
        length = _length(lanes, i, largest_grazing_speed)
        lanes[_GROWTH + i] += math.log(length)
        lanes[_TANGENT_TIME + i] /= length
        lanes[_TANGENT_SPEED + i] /= length


@lane_kernel
def _grow(oscillator, tables, impacts, t, v, growth, elapsed):
    """Follow at most LANES trajectories; t and v become where they end."""
    lanes, corners = lane_buffer(_FIELDS), np.zeros(LANES, np.int64)
    stiff, radian, slow = math.isfinite(oscillator.stiffness), ringing_radian(oscillator), slow_part(oscillator)
    top = tables.largest_grazing_speed
    for i in range(LANES):
        lanes[_LEFT + i] = math.inf
        if i < t.size:
            depart(lanes, i, t[i], v[i])
            lanes[_LEFT + i] = impacts + _ALIGNING
        lanes[_TANGENT_TIME + i] = 1.0
    flying, flights = t.size, 0
    while flying > 0:
        if flying < LANES:
            for i in range(LANES):
                if lanes[_LEFT + i] == math.inf:
                    idle(lanes, i, top)
        fly(lanes, corners, oscillator, tables)
        _turn_by_flights(lanes, oscillator, top)
        if stiff:
            begin_at_the_end(lanes)
            stay(lanes, corners, oscillator, tables, slow)
            _turn_by_contacts(lanes, oscillator)
        flights += 1
        if flights % _RESCALED_AFTER == 0:
            _rescale(lanes, top)
        if _note_returns(lanes, tables.capture_bound, radian, float(impacts)) == 0:
            continue
        for i in range(t.size):
            if lanes[_EVENT + i] == _NOTHING or lanes[_LEFT + i] == math.inf:
                continue
            if lanes[_EVENT + i] == _COUNTED:
                grown = lanes[_GROWTH + i] + math.log(_length(lanes, i, top))
                growth[i], elapsed[i] = grown - growth[i], lanes[_ELAPSED + i] - elapsed[i]
                t[i], v[i] = lanes[PHASE + i], -lanes[VELOCITY + i]
            else:
                t[i] = v[i] = growth[i] = elapsed[i] = math.nan
            if lanes[_EVENT + i] == _ENDED or lanes[_LEFT + i] == 0.0:
                lanes[_LEFT + i] = math.inf
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
