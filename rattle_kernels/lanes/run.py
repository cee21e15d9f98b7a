"""Many applications of P to many points: 64 trajectories fly side by side, a lane that is done takes the next point.

A point goes through `applications` of P unless one of three shortcuts ends it early. Neither changes where it lands:

*Lock.* Brent's checkpoints: the state after 16, 32, 64, ... applications is kept, and a later state within 1e-13 of it
closes a period p. The orbit has then converged: of the applications left only their number modulo p is still to be
done. Closing on a checkpoint after n applications needs the distance to the orbit to shrink like lambda^n below the
tolerance, so ``1 - lambda >= 30/n`` about, and what is left of the distance is at most ``1e-13/(1 - lambda) <= 1e-13
n/30``.

*Capture.* A departure in the safe region of `capture` bounces ever lower and never rattles again. (A stay in contact
that does not end is no shortcut: there is no next departure.)

*Trap.* Every 1024 impacts at the most a trajectory is looked at: inside a trap of an orbit (`trap`) its phase on it is
known, so where it lands is a point of the orbit, once the contraction that the trap was tested for leaves no more than
1e-9 of a distance. Traps are handed in; without, there is no such shortcut.

A chaotic trajectory does all of its applications. Each lane's arithmetic is the same whichever lane it is and whatever
its neighbours do, so a result depends on nothing but its starting point.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.apply import NOT_CONVERGED, OUTSIDE_SECTION, RETURNED, Impacts
from rattle_kernels.impact_map.chatter import level_bound, stay_time
from rattle_kernels.lanes.contact import guess_stays, refine_stays, stay_carefully
from rattle_kernels.lanes.flight import (
    DROPS,
    END_ACCELERATION,
    END_PHASE,
    END_VELOCITY,
    FLIGHT_FIELDS,
    LANES,
    PHASE,
    VELOCITY,
    count_set,
    fly_carefully,
    guess_durations,
    lane_buffer,
    refine_durations,
)
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.lanes.traps import NO_TRAPS, NOWHERE, LaneTraps, nearest_point, potential_in
from rattle_kernels.model.contact import slow_part
from rattle_kernels.model.oscillator import Oscillator, check_domain
from rattle_kernels.model.outcome import Outcome
from rattle_kernels.numerics.jit import inlined, lane_kernel
from rattle_kernels.numerics.pausing import Pause, never_stopped

CAPTURED = int(Outcome.PERMANENT_CONTACT)
_LOCK_TOLERANCE = 1e-13
_FIRST_CHECKPOINT = 16.0
_LONGEST_LEG = 1024.0
_NEAR_ENOUGH = 1e-9

# Fields of the buffer beside those of a flight. Counts are floats so that all loops work on one type.
_DONE = (FLIGHT_FIELDS + 0) * LANES
_WANTED = (FLIGHT_FIELDS + 1) * LANES
_LOWER = (FLIGHT_FIELDS + 2) * LANES
_CHECK_PHASE = (FLIGHT_FIELDS + 3) * LANES
_CHECK_SPEED = (FLIGHT_FIELDS + 4) * LANES
_CHECK_DONE = (FLIGHT_FIELDS + 5) * LANES
_CHECK_NEXT = (FLIGHT_FIELDS + 6) * LANES
_EVENT = (FLIGHT_FIELDS + 7) * LANES
_POINT = (FLIGHT_FIELDS + 8) * LANES
_LOOK_NEXT = (FLIGHT_FIELDS + 9) * LANES
_AWAITED = (FLIGHT_FIELDS + 10) * LANES
_FIELDS = FLIGHT_FIELDS + 11

_NOTHING, _FINISHED, _CAPTURE, _LOCK, _LOST, _LOOK = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0
_NOBODY = -1.0
_NOT_BEGUN = -1
# Of all lanes, some microseconds each: a tenth of a second.
_STEPS_A_LEG = 1 << 16


class _Flights(NamedTuple):
    """What a run goes on from after a pause: lanes, corners of their guesses, and counts of `_run_lanes`."""

    lanes: np.ndarray
    corners: np.ndarray
    counts: np.ndarray


class LaneRun(NamedTuple):
    """What a batch did: applications of P, and flights and stays that took the careful path."""

    applications: int
    careful_flights: int


@inlined
def _advance(lanes, capture_bound, radian, lock_tolerance, speed_scale):
    """Move every lane to the end of its flight and note what has happened there."""
    speed_tolerance = lock_tolerance * speed_scale
    for i in range(LANES):
        phase, velocity = lanes[END_PHASE + i], lanes[END_VELOCITY + i]
        drops = lanes[DROPS + i]
        returns = drops == 0.0
        done = lanes[_DONE + i] + (1.0 - drops)
        away = abs(phase - lanes[_CHECK_PHASE + i]) <= lock_tolerance
        away = away if abs(-velocity - lanes[_CHECK_SPEED + i]) <= speed_tolerance else False
        event = _LOOK if done >= lanes[_LOOK_NEXT + i] else _NOTHING
        event = _LOCK if away else event
        event = _FINISHED if done >= lanes[_WANTED + i] else event
        acceleration = lanes[END_ACCELERATION + i]
        event = _CAPTURE if level_bound(radian, acceleration, -velocity) < capture_bound * acceleration else event
        event = _CAPTURE if velocity == 0.0 else event  # a stay that does not end
        # A checkpoint is set on a return only, and never where an event is to be handled.
        sets = (done >= lanes[_CHECK_NEXT + i]) & returns & (event == _NOTHING)
        lanes[_CHECK_PHASE + i] = phase if sets else lanes[_CHECK_PHASE + i]
        lanes[_CHECK_SPEED + i] = -velocity if sets else lanes[_CHECK_SPEED + i]
        lanes[_CHECK_DONE + i] = done if sets else lanes[_CHECK_DONE + i]
        lanes[_CHECK_NEXT + i] = 2.0 * done if sets else lanes[_CHECK_NEXT + i]
        event = event if returns else _NOTHING
        lanes[_EVENT + i] = event if phase == phase else _LOST  # NaN: a root-finder gave up
        lanes[_DONE + i] = done
        lanes[_LOWER + i] += drops
        lanes[PHASE + i] = phase
        lanes[VELOCITY + i] = velocity
    return count_set(lanes, _EVENT)


@inlined
def _forget_checkpoint(lanes, i, following):
    lanes[_CHECK_PHASE + i] = math.nan
    lanes[_CHECK_SPEED + i] = math.nan
    lanes[_CHECK_DONE + i] = 0.0
    lanes[_CHECK_NEXT + i] = following


@inlined
def _load(lanes, i, point, phase, speed, wanted, checkpoint, look):
    lanes[PHASE + i] = phase - math.floor(phase)
    lanes[VELOCITY + i] = -speed
    lanes[_DONE + i] = 0.0
    lanes[_WANTED + i] = wanted
    lanes[_LOWER + i] = 0.0
    lanes[_POINT + i] = point
    lanes[_EVENT + i] = _NOTHING
    lanes[_LOOK_NEXT + i] = look
    lanes[_AWAITED + i] = NOWHERE
    _forget_checkpoint(lanes, i, checkpoint)


@inlined
def _next_point(t, v, outcome, point):
    """The first point from `point` on that is a departure; others are answered at once."""
    while point < t.size and not (math.isfinite(t[point]) and math.isfinite(v[point]) and v[point] > 0.0):
        t[point] = v[point] = math.nan
        outcome[point] = OUTSIDE_SECTION
        point += 1
    return point


@inlined
def _arrives(lanes, i, traps, orbit):
    """Whether lane i is in the trap of an orbit, beside its slowest point, and will be at its end; it is put there."""
    value = potential_in(traps, orbit, lanes[PHASE + i], -lanes[VELOCITY + i])
    if not value == value:
        return False
    left = lanes[_WANTED + i] - lanes[_DONE + i]
    turns = math.floor(left / traps.period[orbit])
    point = traps.first[orbit] + int(left - turns * traps.period[orbit])
    at_end = math.sqrt(value / traps.floor[orbit]) * math.exp(-0.5 * traps.rate[orbit] * turns)
    # Near the orbit displacements are carried on linearly; twice that is a bound.
    if 2.0 * traps.stretch[point] * at_end > _NEAR_ENOUGH:
        lanes[_LOOK_NEXT + i] = math.inf  # in the trap, but not for long enough
        return False
    lanes[PHASE + i], lanes[VELOCITY + i] = traps.time[point], -traps.speed[point]
    return True


@inlined
def _is_far(lanes, i, nearest, top):
    """Whether lane i, which was to look where it is, is near no orbit with a trap; then when to look again."""
    if lanes[_EVENT + i] != _LOOK or lanes[_AWAITED + i] != NOWHERE:
        return False
    if nearest_point(nearest, top, lanes[PHASE + i], -lanes[VELOCITY + i]) != NOWHERE:
        return False
    lanes[_LOOK_NEXT + i] = lanes[_DONE + i] + min(lanes[_DONE + i], _LONGEST_LEG)
    return True


@inlined
def _look(lanes, i, traps):
    """Whether lane i, near an orbit, has arrived for good; else say when to look again."""
    done = lanes[_DONE + i]
    orbit = int(lanes[_AWAITED + i])
    if orbit == NOWHERE:
        point = nearest_point(traps.nearest, traps.top, lanes[PHASE + i], -lanes[VELOCITY + i])
        orbit, place = traps.orbit[point], traps.place[point]
        if place > 0:
            lanes[_AWAITED + i], lanes[_LOOK_NEXT + i] = orbit, done + (traps.period[orbit] - place)
            return False
    lanes[_AWAITED + i] = NOWHERE
    lanes[_LOOK_NEXT + i] = done + min(done, _LONGEST_LEG)
    return _arrives(lanes, i, traps, orbit)


@inlined
def _settle(lanes, i, traps):
    """Whether lane i is done; a lock leaves it the rest of its applications modulo the period."""
    if lanes[_EVENT + i] == _LOOK:
        return _look(lanes, i, traps)
    if lanes[_EVENT + i] != _LOCK:
        return True
    lanes[_LOOK_NEXT + i] = math.inf
    done = lanes[_DONE + i]
    left = (lanes[_WANTED + i] - done) % (done - lanes[_CHECK_DONE + i])
    lanes[_WANTED + i] = done + left
    _forget_checkpoint(lanes, i, math.inf)
    return left == 0.0


@inlined
def _refill(lanes, i, tables, applications, first_look, points, following):
    """Give lane i the next point, or let it idle at a speed at which it is never unsure; return the point after."""
    t, v, outcome = points
    point = _next_point(t, v, outcome, following)
    if point < t.size:
        _load(lanes, i, point, t[point], v[point], applications, _FIRST_CHECKPOINT, first_look)
        return point + 1
    _load(lanes, i, _NOBODY, 0.0, 1e6 * tables.speed_scale, math.inf, math.inf, math.inf)
    return point


@inlined
def _outcome_of(event):
    if event == _LOST:
        return NOT_CONVERGED
    return CAPTURED if event == _CAPTURE else RETURNED


@inlined
def _land(lanes, i, points, lower_impacts):
    """Write down where the point of lane i has landed; return the applications it took."""
    t, v, outcome = points
    point = int(lanes[_POINT + i])
    ended = _outcome_of(lanes[_EVENT + i])
    departs = ended != NOT_CONVERGED and lanes[VELOCITY + i] != 0.0
    t[point] = lanes[PHASE + i] if departs else math.nan
    v[point] = -lanes[VELOCITY + i] if departs else math.nan
    lower_impacts[point] = int(lanes[_LOWER + i])
    outcome[point] = ended
    return lanes[_DONE + i]


@lane_kernel
def _run_lanes(oscillator, tables, traps, applications, capture_bound, lock_tolerance, points, lower_impacts, flights):
    """Fly on for a leg; `flights.counts` has the next point, lanes that fly, careful flights and applications so far.

    Lanes are copied here and back: loops over a buffer that the compiler has seen being made are faster.
    """
    lanes = lane_buffer(_FIELDS)
    corners = np.zeros(LANES, np.int64)
    lanes[:], corners[:] = flights.lanes, flights.corners
    following, flying, careful = flights.counts[0], flights.counts[1], flights.counts[2]
    first_look = _FIRST_CHECKPOINT if traps.orbit.size > 0 else math.inf
    if flying == _NOT_BEGUN:
        flying = 0
        for i in range(LANES):
            following = _refill(lanes, i, tables, applications, first_look, points, following)
            flying += 1 if lanes[_POINT + i] != _NOBODY else 0
    stiff, radian, slow = math.isfinite(oscillator.stiffness), stay_time(oscillator), slow_part(oscillator)
    nearest, top = traps.nearest, traps.top
    done = 0.0
    steps = _STEPS_A_LEG
    while flying > 0 and steps > 0:
        steps -= 1
        guess_durations(lanes, corners, tables, 2.0 * oscillator.half_backlash)
        unsure = refine_durations(lanes, oscillator.damping, oscillator.eccentricity)
        if unsure > 0:
            careful += unsure
            fly_carefully(lanes, oscillator)
        if stiff:
            guess_stays(lanes, corners, tables)
            unsure = refine_stays(lanes, oscillator.damping, slow)
            if unsure > 0:
                careful += unsure
                stay_carefully(lanes, oscillator)
        if _advance(lanes, capture_bound, radian, lock_tolerance, tables.speed_scale) == 0:
            continue
        flying = 0
        for i in range(LANES):
            if lanes[_POINT + i] == _NOBODY:
                continue
            far = lanes[_EVENT + i] == _NOTHING or _is_far(lanes, i, nearest, top)
            if not far and _settle(lanes, i, traps):
                done += _land(lanes, i, points, lower_impacts)
                following = _refill(lanes, i, tables, applications, first_look, points, following)
            flying += 1 if lanes[_POINT + i] != _NOBODY else 0
    flights.lanes[:], flights.corners[:] = lanes, corners
    flights.counts[0], flights.counts[1], flights.counts[2] = following, flying, careful
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
        periods. Without, ``lower_impacts`` counts all contacts; with, those of the applications done.
    traps : LaneTraps
        Points that are caught in one land on its orbit at once.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    Impacts, LaneRun
        Landing points, and what it took.
    """
    tables = lane_tables(oscillator)
    phase, speed = t.copy(), v.copy()
    lower_impacts, outcome = np.zeros(t.size, np.int64), np.zeros(t.size, np.int8)
    bound, tolerance = (tables.capture_bound, _LOCK_TOLERANCE) if shortcuts else (0.0, -1.0)
    points = (phase, speed, outcome)
    flights = _Flights(np.zeros(_FIELDS * LANES), np.zeros(LANES, np.int64), np.array([0, _NOT_BEGUN, 0, 0]))
    given = oscillator, tables, traps, float(applications), bound, tolerance, points, lower_impacts, flights
    while flights.counts[1] != 0:
        pause()
        _run_lanes(*given)
    return Impacts(phase, speed, lower_impacts, outcome), LaneRun(int(flights.counts[3]), int(flights.counts[2]))


def next_impacts(
    oscillator: Oscillator, t: np.typing.ArrayLike, v: np.typing.ArrayLike, applications: int = 1
) -> Impacts:
    """Apply P to every point.

    Parameters
    ----------
    oscillator : Oscillator
    t, v : array_like, broadcast together
        Phase (forcing periods, any finite value) and speed of departures from +beta.
    applications : int
        How often P is applied; all of them, no shortcut.

    Returns
    -------
    Impacts
        ``lower_impacts`` counts the contacts with -beta of all applications.

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
    impacts, _ = run_lanes(checked, phase.ravel(), speed.ravel(), applications, shortcuts=False)
    return Impacts(*(field.reshape(phase.shape) for field in impacts))
