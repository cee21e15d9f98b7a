"""One flight of every lane of a loose gear, by the scalar path, and what comes of the contact at its end.

The fields of the lanes are those of `flight`. A motion that chatters to rest departs next at its release
(`complete_chatter`): its time includes the bounces and the rest, and ARRIVAL has the speed of the first of them.
"""

import math

from rattle_kernels.impact_map.arc_flights import next_loose_contact
from rattle_kernels.impact_map.complete_chatter import accumulates
from rattle_kernels.impact_map.flights import LOWER, UPPER
from rattle_kernels.impact_map.loose_map import leave
from rattle_kernels.lanes.lane_fields import (
    DROPS,
    DURATION,
    END_ACCELERATION,
    END_PHASE,
    END_VELOCITY,
    LANES,
    MISS,
    PHASE,
    RATE,
    VELOCITY,
)
from rattle_kernels.numerics.jit import chosen_by_field, inlined

# Fields that no other flight of a loose gear uses.
_RESTS, _ARRIVAL = MISS, RATE


@inlined
def fly_loosely(lanes, corners, oscillator, tables):
    """Fly every lane to the next wall; return how many took the careful path, which are all.

    Parameters
    ----------
    lanes : ndarray of float64
        The buffer.
    corners : ndarray of int64
        Not used.
    oscillator : LooseOscillator
        Checked by the caller.
    tables : LooseTables

    Returns
    -------
    int
    """
    for i in range(LANES):
        velocity = lanes[VELOCITY + i]
        wall = LOWER if velocity > 0.0 else UPPER
        end = next_loose_contact(oscillator, wall, lanes[PHASE + i], velocity)
        speed, upper = abs(end.velocity), end.wall == UPPER
        jumps_below = tables.upper_jumps_below if upper else tables.lower_jumps_below
        leaves = leave(oscillator, end.wall, end.phase, oscillator.restitution * speed, jumps_below)
        # A gear that is never released stays in contact.
        leaves_at = leaves.speed if math.isfinite(leaves.after) else 0.0
        lanes[DURATION + i] = end.duration + leaves.after
        lanes[END_PHASE + i] = leaves.phase if end.found else math.nan
        lanes[END_VELOCITY + i] = -leaves_at if upper else leaves_at
        lanes[END_ACCELERATION + i] = 1.0
        lanes[DROPS + i] = 0.0 if upper else 1.0
        lanes[_RESTS + i], lanes[_ARRIVAL + i] = 1.0 if leaves.rests else 0.0, speed
    return LANES


@inlined
def stay_in_no_contact(lanes, corners, oscillator, tables, slow):
    """The impacting model alone is followed beyond the bound of Eq. (8)."""
    return 0


@inlined
def _loose_arrival_speed(oscillator, lanes, i):
    return lanes[_ARRIVAL + i]


@chosen_by_field("arcs", _loose_arrival_speed)
def arrival_speed(oscillator, lanes, i):
    """Speed with which lane i has met the wall at the end of its flight."""
    return abs(lanes[END_VELOCITY + i]) / oscillator.restitution


@inlined
def _loose_has_rested(oscillator, lanes, i):
    return lanes[_RESTS + i] != 0.0


@chosen_by_field("arcs", _loose_has_rested)
def has_rested(oscillator, lanes, i):
    """Whether lane i has come to rest after its flight, and been released."""
    return False


@inlined
def _loose_chatters_on(oscillator, lanes, i):
    return accumulates(oscillator, UPPER, lanes[PHASE + i], -lanes[VELOCITY + i])


@chosen_by_field("arcs", _loose_chatters_on)
def chatters_on(oscillator, lanes, i):
    """Whether lane i, which is at a departure, is on its way to a rest: P leads from before it to the release."""
    return False
