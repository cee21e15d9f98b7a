"""Shortcuts that end a lane's trajectory early; none changes where it lands.

*Lock.* Brent's checkpoints: the state after 16, 32, 64, ... applications is kept, and a later state within 1e-13 of it
closes a period p. The orbit has then converged, and only the number of applications left modulo p is still to be done.
Closing on a checkpoint after n applications needs the distance to the orbit to shrink like lambda^n below the
tolerance, so ``1 - lambda >= 30/n`` about. What is left of the distance is at most ``1e-13/(1 - lambda) <= 1e-13
n/30``.

*Capture.* A departure in the safe region of `chatter` bounces ever lower and never rattles again. (A contact that does
not end is no shortcut: there is no next departure.)

*Trap.* After 1024 impacts at most the position of a trajectory is checked. Inside the trap of an orbit
(`attractors.trapping_region`) its phase on the orbit is known. So it lands on a point of the orbit, provided that the
contraction for which the trap was tested leaves a distance of at most 1e-9.
"""

import math

from rattle_kernels.impact_map.chatter import is_below
from rattle_kernels.lanes.lane_fields import (
    DROPS,
    END_ACCELERATION,
    END_PHASE,
    END_VELOCITY,
    FLIGHT_FIELDS,
    LANES,
    PHASE,
    VELOCITY,
    count_set,
)
from rattle_kernels.lanes.traps import NOWHERE, nearest_point, potential_in
from rattle_kernels.numerics.jit import always_inlined, inlined

_LONGEST_LEG = 1024.0
_NEAR_ENOUGH = 1e-9

# Fields of the buffer beside those of a flight. Counts are floats so that all loops work on one type.
DONE = (FLIGHT_FIELDS + 0) * LANES
WANTED = (FLIGHT_FIELDS + 1) * LANES
LOWER_IMPACTS = (FLIGHT_FIELDS + 2) * LANES
_CHECK_PHASE = (FLIGHT_FIELDS + 3) * LANES
_CHECK_SPEED = (FLIGHT_FIELDS + 4) * LANES
_CHECK_NEXT = (FLIGHT_FIELDS + 5) * LANES  # the checkpoint that is set was set after half as many applications
EVENT = (FLIGHT_FIELDS + 6) * LANES
POINT = (FLIGHT_FIELDS + 7) * LANES
_LOOK_NEXT = (FLIGHT_FIELDS + 8) * LANES
_AWAITED = (FLIGHT_FIELDS + 9) * LANES
RUN_FIELDS = FLIGHT_FIELDS + 10

# What has happened to a lane at the end of a flight.
NOTHING, FINISHED, CAPTURED, LOCKED, LOST, LOOKS = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0


@always_inlined
def note_events(lanes, capture_bound, radian, lock_tolerance, largest_grazing_speed):
    """Move every lane to the end of its flight and note what has happened there; return how many have an event."""
    speed_tolerance = lock_tolerance * largest_grazing_speed
    for i in range(LANES):
        phase, velocity = lanes[END_PHASE + i], lanes[END_VELOCITY + i]
        drops = lanes[DROPS + i]
        returns = drops == 0.0
        done = lanes[DONE + i] + (1.0 - drops)
        away = abs(phase - lanes[_CHECK_PHASE + i]) <= lock_tolerance
        away = away if abs(-velocity - lanes[_CHECK_SPEED + i]) <= speed_tolerance else False
        event = LOOKS if done >= lanes[_LOOK_NEXT + i] else NOTHING
        event = LOCKED if away else event
        event = FINISHED if done >= lanes[WANTED + i] else event
        event = CAPTURED if is_below(capture_bound, radian, lanes[END_ACCELERATION + i], -velocity) else event
        event = CAPTURED if velocity == 0.0 else event  # a contact that does not end
        # A checkpoint is set on a return only, and never where an event is to be handled.
        sets = (done >= lanes[_CHECK_NEXT + i]) & returns & (event == NOTHING)
        lanes[_CHECK_PHASE + i] = phase if sets else lanes[_CHECK_PHASE + i]
        lanes[_CHECK_SPEED + i] = -velocity if sets else lanes[_CHECK_SPEED + i]
        lanes[_CHECK_NEXT + i] = 2.0 * done if sets else lanes[_CHECK_NEXT + i]
        event = event if returns else NOTHING
        lanes[EVENT + i] = event if phase == phase else LOST  # NaN: a root-finder gave up
        lanes[DONE + i] = done
        lanes[LOWER_IMPACTS + i] += drops
        lanes[PHASE + i] = phase
        lanes[VELOCITY + i] = velocity
    return count_set(lanes, EVENT)


@inlined
def _forget_checkpoint(lanes, i, next_checkpoint):
    lanes[_CHECK_PHASE + i] = math.nan
    lanes[_CHECK_SPEED + i] = math.nan
    lanes[_CHECK_NEXT + i] = next_checkpoint


@inlined
def begin_run(lanes, i, point, wanted, first_checkpoint, first_look):
    """Set the counts of lane i, which has departed with a point and is to do so many applications."""
    lanes[DONE + i] = 0.0
    lanes[WANTED + i] = wanted
    lanes[LOWER_IMPACTS + i] = 0.0
    lanes[POINT + i] = point
    lanes[EVENT + i] = NOTHING
    lanes[_LOOK_NEXT + i] = first_look
    lanes[_AWAITED + i] = NOWHERE
    _forget_checkpoint(lanes, i, first_checkpoint)


@inlined
def _lands_on(lanes, i, traps, orbit):
    """Put lane i where it ends, if it is in the trap of an orbit, beside its slowest point, and ends near the orbit."""
    value = potential_in(traps, orbit, lanes[PHASE + i], -lanes[VELOCITY + i])
    if not value == value:
        return False
    left = lanes[WANTED + i] - lanes[DONE + i]
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
def is_far(lanes, i, nearest, top):
    """Whether lane i, due to be checked, is near no orbit with a trap; if so, set when to check next."""
    if lanes[EVENT + i] != LOOKS or lanes[_AWAITED + i] != NOWHERE:
        return False
    if nearest_point(nearest, top, lanes[PHASE + i], -lanes[VELOCITY + i]) != NOWHERE:
        return False
    lanes[_LOOK_NEXT + i] = lanes[DONE + i] + min(lanes[DONE + i], _LONGEST_LEG)
    return True


@inlined
def _look(lanes, i, traps):
    """Whether lane i, near an orbit, is done; otherwise set when to check next."""
    done = lanes[DONE + i]
    orbit = int(lanes[_AWAITED + i])
    if orbit == NOWHERE:
        point = nearest_point(traps.nearest, traps.top, lanes[PHASE + i], -lanes[VELOCITY + i])
        orbit, place = traps.orbit[point], traps.place[point]
        if place > 0:
            lanes[_AWAITED + i], lanes[_LOOK_NEXT + i] = orbit, done + (traps.period[orbit] - place)
            return False
    lanes[_AWAITED + i] = NOWHERE
    lanes[_LOOK_NEXT + i] = done + min(done, _LONGEST_LEG)
    return _lands_on(lanes, i, traps, orbit)


@inlined
def settles(lanes, i, traps):
    """Whether lane i is done; a lock leaves it the rest of its applications modulo the period."""
    if lanes[EVENT + i] == LOOKS:
        return _look(lanes, i, traps)
    if lanes[EVENT + i] != LOCKED:
        return True
    lanes[_LOOK_NEXT + i] = math.inf
    done = lanes[DONE + i]
    left = (lanes[WANTED + i] - done) % (done - 0.5 * lanes[_CHECK_NEXT + i])
    lanes[WANTED + i] = done + left
    _forget_checkpoint(lanes, i, math.inf)
    return left == 0.0
