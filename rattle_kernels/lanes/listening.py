"""Lanes that are listened to: impacts, their energy and the time that they take, until a motion is captured.

An impact is an arrival at a wall, on +beta or on -beta, with the speed v_i of arrival. In the piecewise linear model it
is a contact, and v_i is the speed of entering it. The flights are those of `run`, to the bit. A lane takes the next
point as soon as its own has ended, so points that are captured at once cost nothing.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.chatter import is_captured
from rattle_kernels.lanes.advance import begin_at_the_end, depart, fly, idle, stay
from rattle_kernels.lanes.lane_fields import (
    DROPS,
    DURATION,
    FLIGHT_FIELDS,
    LANES,
    PHASE,
    VELOCITY,
    lane_buffer,
)
from rattle_kernels.lanes.loose_flight import arrival_speed, chatters_on, rest_time
from rattle_kernels.lanes.tables import LaneTables, LooseTables, lane_tables
from rattle_kernels.model.contact import slow_part
from rattle_kernels.model.departures import check_departures
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import (
    OUTCOME_NOT_CONVERGED,
    OUTCOME_PERMANENT_CONTACT,
    OUTCOME_RETURNED,
)
from rattle_kernels.numerics.jit import inlined, lane_kernel
from rattle_kernels.numerics.pausing import Pause, never_stopped

IMPACTS, SQUARES, LARGEST, TIME, CONTACT = range(5)
"""Columns of what is heard: impacts, sum of squares of their speeds, the largest, the time taken, that in contact."""

_NOBODY = -1
# Of the scale of speeds. Bounces of a chatter that are slower have 1e-16 of an impact's energy, all together.
_INAUDIBLE = 1e-9
# Between two pauses: a leg of so many applications of so many points takes a quarter of a second.
_POINTS_AT_A_TIME, _APPLICATIONS_A_LEG = 4096, 4096


def listening_tables(oscillator: Oscillator) -> LaneTables | LooseTables:
    """What lanes that are listened to need to know: bounces of a chatter are heard until they are nothing.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.

    Returns
    -------
    LaneTables or LooseTables
    """
    tables = lane_tables(oscillator)
    if isinstance(tables, LooseTables):
        nothing = _INAUDIBLE * tables.largest_grazing_speed
        return tables._replace(upper_jumps_below=nothing, lower_jumps_below=nothing)
    return tables


@inlined
def _end_of(oscillator, bound, phase, speed):
    """How a motion has ended that is at a departure; RETURNED where it goes on."""
    if not phase == phase:
        return OUTCOME_NOT_CONVERGED
    if not speed > 0.0 or is_captured(oscillator, bound, phase, speed):
        return OUTCOME_PERMANENT_CONTACT
    return OUTCOME_RETURNED


@lane_kernel
def listen(oscillator, tables, applications, t, v, heard, outcome):
    """Listen to points until they are captured, or P has been applied a number of times.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    tables : LaneTables
    applications : int
        Of P, to each point.
    t, v : ndarray of float64, shape (n,)
        Departures from +beta. They become the last departure.
    heard : ndarray of float64, shape (n, 5)
        What is heard is added to it; its columns are IMPACTS, SQUARES, LARGEST, TIME and CONTACT.
    outcome : ndarray of int8, shape (n,)
        Becomes RETURNED, PERMANENT_CONTACT where a point is captured, or NOT_CONVERGED.
    """
    lanes, corners = lane_buffer(FLIGHT_FIELDS), np.zeros(LANES, np.int64)
    point, left = np.full(LANES, _NOBODY), np.zeros(LANES, np.int64)
    stiff, slow, bound = math.isfinite(oscillator.stiffness), slow_part(oscillator), tables.capture_bound
    next_point, flying = 0, 0
    while flying > 0 or next_point < t.size:
        for i in range(LANES):
            while point[i] == _NOBODY and next_point < t.size:
                outcome[next_point] = _end_of(oscillator, bound, t[next_point], v[next_point])
                if outcome[next_point] == OUTCOME_RETURNED:
                    point[i], left[i] = next_point, applications
                    depart(lanes, i, t[next_point], v[next_point])
                    flying += 1
                next_point += 1
            if point[i] == _NOBODY:
                idle(lanes, i, tables.largest_grazing_speed)
        if flying == 0:
            break
        fly(lanes, corners, oscillator, tables)
        for i in range(LANES):
            if point[i] != _NOBODY:
                at, speed = point[i], arrival_speed(oscillator, lanes, i)
                heard[at, IMPACTS] += 1.0
                heard[at, SQUARES] += speed * speed
                heard[at, LARGEST] = max(heard[at, LARGEST], speed)
                heard[at, TIME] += lanes[DURATION + i]
                heard[at, CONTACT] += rest_time(oscillator, lanes, i)
        if stiff:
            stay(lanes, corners, oscillator, tables, slow)
        begin_at_the_end(lanes)
        for i in range(LANES):
            if point[i] == _NOBODY:
                continue
            at, phase, speed = point[i], lanes[PHASE + i], -lanes[VELOCITY + i]
            # A contact that does not end takes no time: the motion is quiet from its beginning on.
            if stiff and speed != 0.0:
                heard[at, TIME] += lanes[DURATION + i]
                heard[at, CONTACT] += lanes[DURATION + i]
            if phase == phase and (lanes[DROPS + i] != 0.0 or chatters_on(oscillator, lanes, i)):
                continue
            left[i] -= 1
            outcome[at] = _end_of(oscillator, bound, phase, speed)
            if outcome[at] != OUTCOME_RETURNED or left[i] == 0:
                t[at], v[at], point[i] = phase, speed, _NOBODY
                flying -= 1


class Episodes(NamedTuple):
    """What is heard of motions until they are captured; arrays of one shape.

    ``duration`` counts forcing periods, ``impacts`` arrivals on both walls. ``impact_energy`` is ``sum v_i^2/2``, and
    ``largest_impact_speed`` the greatest v_i. ``captured`` is False where a motion was not within the applications
    allowed, or a root-finder gave up; the numbers are then those up to there.
    """

    duration: np.ndarray
    impacts: np.ndarray
    impact_energy: np.ndarray
    largest_impact_speed: np.ndarray
    captured: np.ndarray


def until_captured(
    oscillator: Oscillator,
    t: np.typing.ArrayLike,
    v: np.typing.ArrayLike,
    *,
    applications: int = 1 << 20,
    pause: Pause = never_stopped,
) -> Episodes:
    """Follow departures until ever lower bounces have captured them, or contact does not end.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    t, v : array_like, shape (n,)
        Phases and speeds of departures from +beta.
    applications : int
        How often P is applied at most. A motion that rattles for ever
        takes them all: `name_solutions` says which do.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    Episodes
        Zeros for a departure that is captured from the beginning. What a captured motion bounces after that is not in
        it.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.
    ValueError
        If a point is no departure, or ``applications`` is below 1.

    Examples
    --------
    >>> heard = until_captured(Oscillator(), [0.6, 0.6], [0.1, 3.0])
    >>> heard.captured, heard.impacts
    (array([ True,  True]), array([ 0, 32]))
    """
    checked = check_oscillator(oscillator)
    if applications < 1:
        raise ValueError(f"applications must be at least 1, not {applications}")
    times, speeds = (np.array(each) for each in np.broadcast_arrays(*np.atleast_1d(*check_departures(t, v))))
    shape, times, speeds = times.shape, times.ravel(), speeds.ravel()
    tables, heard = listening_tables(checked), np.zeros((times.size, 5))
    captured = np.zeros(times.size, bool)
    for first in range(0, times.size, _POINTS_AT_A_TIME):
        going = np.arange(first, min(first + _POINTS_AT_A_TIME, times.size))
        for done in range(0, applications, _APPLICATIONS_A_LEG):
            pause()
            leg = min(applications - done, _APPLICATIONS_A_LEG)
            where, fast, more = times[going], speeds[going], heard[going]
            outcome = np.empty(going.size, np.int8)
            listen(checked, tables, leg, where, fast, more, outcome)
            times[going], speeds[going], heard[going] = where, fast, more
            captured[going] = outcome == OUTCOME_PERMANENT_CONTACT
            going = going[outcome == OUTCOME_RETURNED]
            if not going.size:
                break
    impacts, squares, largest, time, _ = heard.T.reshape(5, *shape)
    return Episodes(time, impacts.astype(np.int64), 0.5 * squares, largest, captured.reshape(shape))
