"""Many applications of P to many points: 64 trajectories fly side by side; a lane that is done takes the next point.

A point goes through `applications` of P unless one of three shortcuts ends it early (`shortcuts`). A chaotic trajectory
does all of them. Each lane's arithmetic is the same whichever lane it is and whatever its neighbours do, so a result
depends on nothing but its starting point.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.apply import Impacts
from rattle_kernels.impact_map.chatter import ringing_radian
from rattle_kernels.lanes.advance import depart, fly, idle, stay
from rattle_kernels.lanes.flight import LANES, PHASE, VELOCITY, lane_buffer
from rattle_kernels.lanes.shortcuts import (
    CAPTURED,
    DONE,
    EVENT,
    LOST,
    LOWER_IMPACTS,
    NOTHING,
    POINT,
    RUN_FIELDS,
    begin_run,
    is_far,
    note_events,
    settles,
)
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.lanes.traps import NO_TRAPS, LaneTraps
from rattle_kernels.model.contact import slow_part
from rattle_kernels.model.oscillator import Oscillator, check_domain
from rattle_kernels.model.outcome import (
    OUTCOME_NOT_CONVERGED,
    OUTCOME_OUTSIDE_SECTION,
    OUTCOME_PERMANENT_CONTACT,
    OUTCOME_RETURNED,
)
from rattle_kernels.numerics.jit import inlined, lane_kernel
from rattle_kernels.numerics.pausing import Pause, never_stopped

_LOCK_TOLERANCE = 1e-13
_FIRST_CHECKPOINT = 16.0
_NO_POINT = -1.0
_NOT_BEGUN = -1
# Flights of all lanes between two pauses, some microseconds each: a tenth of a second.
_FLIGHTS_A_LEG = 1 << 16


class _Batch(NamedTuple):
    """Points, which become where they land, and what is counted on the way; arrays of shape (n,)."""

    t: np.ndarray
    v: np.ndarray
    outcome: np.ndarray
    lower_impacts: np.ndarray


class _Rules(NamedTuple):
    """How often P is applied, and when a point is captured or locked."""

    applications: float
    capture_bound: float
    lock_tolerance: float


class _Flights(NamedTuple):
    """What a run goes on from after a pause: lanes, corners of their guesses, and counts of `_run_lanes`."""

    lanes: np.ndarray
    corners: np.ndarray
    counts: np.ndarray


class LaneRun(NamedTuple):
    """What a batch took: applications of P, and flights and contacts on the careful path."""

    applications: int
    careful_flights: int


@inlined
def _next_departure(batch, point):
    """The first point from `point` on that is a departure; the others get their outcome at once."""
    t, v = batch.t, batch.v
    while point < t.size and not (math.isfinite(t[point]) and math.isfinite(v[point]) and v[point] > 0.0):
        t[point] = v[point] = math.nan
        batch.outcome[point] = OUTCOME_OUTSIDE_SECTION
        point += 1
    return point


@inlined
def _refill(lanes, i, tables, applications, first_look, batch, next_point):
    """Give lane i the next point, or let it idle; return the point after it."""
    point = _next_departure(batch, next_point)
    if point < batch.t.size:
        depart(lanes, i, batch.t[point], batch.v[point])
        begin_run(lanes, i, point, applications, _FIRST_CHECKPOINT, first_look)
        return point + 1
    idle(lanes, i, tables.largest_grazing_speed)
    begin_run(lanes, i, _NO_POINT, math.inf, math.inf, math.inf)
    return point


@inlined
def _outcome_of(event):
    if event == LOST:
        return OUTCOME_NOT_CONVERGED
    return OUTCOME_PERMANENT_CONTACT if event == CAPTURED else OUTCOME_RETURNED


@inlined
def _land(lanes, i, batch):
    """Write down where the point of lane i has landed; return the applications it took."""
    point = int(lanes[POINT + i])
    ended = _outcome_of(lanes[EVENT + i])
    departs = ended != OUTCOME_NOT_CONVERGED and lanes[VELOCITY + i] != 0.0
    batch.t[point] = lanes[PHASE + i] if departs else math.nan
    batch.v[point] = -lanes[VELOCITY + i] if departs else math.nan
    batch.lower_impacts[point] = int(lanes[LOWER_IMPACTS + i])
    batch.outcome[point] = ended
    return lanes[DONE + i]


@lane_kernel
def _run_lanes(oscillator, tables, traps, rules, batch, flights):
    """Fly on for a leg; `flights.counts` has the next point, lanes that fly, careful flights and applications so far.

    Lanes are copied here and back: loops over a buffer that the compiler has seen being made are faster.
    """
    lanes = lane_buffer(RUN_FIELDS)
    corners = np.zeros(LANES, np.int64)
    lanes[:], corners[:] = flights.lanes, flights.corners
    next_point, flying, careful = flights.counts[0], flights.counts[1], flights.counts[2]
    first_look = _FIRST_CHECKPOINT if traps.orbit.size > 0 else math.inf
    if flying == _NOT_BEGUN:
        flying = 0
        for i in range(LANES):
            next_point = _refill(lanes, i, tables, rules.applications, first_look, batch, next_point)
            flying += 1 if lanes[POINT + i] != _NO_POINT else 0
    stiff, radian, slow = math.isfinite(oscillator.stiffness), ringing_radian(oscillator), slow_part(oscillator)
    nearest, top = traps.nearest, traps.top
    done = 0.0
    left = _FLIGHTS_A_LEG
    while flying > 0 and left > 0:
        left -= 1
        careful += fly(lanes, corners, oscillator, tables)
        if stiff:
            careful += stay(lanes, corners, oscillator, tables, slow)
        if note_events(lanes, rules.capture_bound, radian, rules.lock_tolerance, tables.largest_grazing_speed) == 0:
            continue
        flying = 0
        for i in range(LANES):
            if lanes[POINT + i] == _NO_POINT:
                continue
            far = lanes[EVENT + i] == NOTHING or is_far(lanes, i, nearest, top)
            if not far and settles(lanes, i, traps):
                done += _land(lanes, i, batch)
                next_point = _refill(lanes, i, tables, rules.applications, first_look, batch, next_point)
            flying += 1 if lanes[POINT + i] != _NO_POINT else 0
    flights.lanes[:], flights.corners[:] = lanes, corners
    flights.counts[0], flights.counts[1], flights.counts[2] = next_point, flying, careful
    flights.counts[3] += int(done)


def run_lanes(
    oscillator: Oscillator,
    t: np.ndarray,
    v: np.ndarray,
    applications: int,
    *,
    shortcuts: bool,
    traps: LaneTraps = NO_TRAPS,
    pause: Pause = never_stopped,
) -> tuple[Impacts, LaneRun]:
    """Apply P many times to many points.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : ndarray of float64, shape (n,)
        Phases and speeds of departures from +beta. Not changed.
    applications : int
        How often P is applied, at least 1.
    shortcuts : bool
        Whether captured points end early (outcome PERMANENT_CONTACT, state at capture) and locked ones skip whole
        periods. With shortcuts ``lower_impacts`` counts contacts of the applications done, without them all contacts.
    traps : LaneTraps
        A point inside a trap lands on its orbit at once.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    Impacts, LaneRun
        Landing points, and what it took.
    """
    rules = _Rules(float(applications), 0.0, -1.0)
    tables = lane_tables(oscillator)
    if shortcuts:
        rules = rules._replace(capture_bound=tables.capture_bound, lock_tolerance=_LOCK_TOLERANCE)
    batch = _Batch(t.copy(), v.copy(), np.zeros(t.size, np.int8), np.zeros(t.size, np.int64))
    flights = _Flights(np.zeros(RUN_FIELDS * LANES), np.zeros(LANES, np.int64), np.array([0, _NOT_BEGUN, 0, 0]))
    while flights.counts[1] != 0:
        pause()
        _run_lanes(oscillator, tables, traps, rules, batch, flights)
    landed = Impacts(batch.t, batch.v, batch.lower_impacts, batch.outcome)
    return landed, LaneRun(int(flights.counts[3]), int(flights.counts[2]))


def next_impacts(
    oscillator: Oscillator,
    t: np.typing.ArrayLike,
    v: np.typing.ArrayLike,
    applications: int = 1,
    *,
    shortcuts: bool = False,
) -> Impacts:
    """Apply P to every point.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    t, v : array_like, broadcast together
        Phase (forcing periods, any finite value) and speed of departures from +beta.
    applications : int
        How often P is applied.
    shortcuts : bool
        Whether a motion that ever lower bounces have captured ends early (outcome PERMANENT_CONTACT, state at capture),
        and one that is locked to a periodic orbit skips whole turns. Long motions then take a fraction of the time.

    Returns
    -------
    Impacts
        ``lower_impacts`` counts the contacts with -beta of all applications; with shortcuts, of those that were done.

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain of the map.
    ValueError
        Where `applications` is below 1.

    Examples
    --------
    >>> impacts = next_impacts(Oscillator(damping=0.6, eccentricity=0.1, half_backlash=0.6), [0.25, 0.5], [1.0, 6.0])
    >>> impacts.lower_impacts
    array([0, 1])
    """
    checked = check_domain(oscillator)
    if applications < 1:
        raise ValueError(f"applications must be at least 1, not {applications}")
    phase, speed = np.broadcast_arrays(np.asarray(t, dtype=np.float64), np.asarray(v, dtype=np.float64))
    impacts, _ = run_lanes(checked, phase.ravel(), speed.ravel(), applications, shortcuts=shortcuts)
    return Impacts(*(field.reshape(phase.shape) for field in impacts))
