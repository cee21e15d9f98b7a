"""Long runs: a point flies in its lane until it lands; then the lane takes the next one.

A point goes through all applications unless one of the shortcuts ends it early (`shortcuts`). A chaotic trajectory does
all of them.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.chatter import ringing_radian
from rattle_kernels.lanes.advance import depart, fly, idle, stay
from rattle_kernels.lanes.batch import Batch, LaneRun, Rules
from rattle_kernels.lanes.lane_fields import LANES, PHASE, VELOCITY, lane_buffer
from rattle_kernels.lanes.short_run import LONGEST_SHORT_RUN
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
from rattle_kernels.lanes.tables import LaneTables, LooseTables
from rattle_kernels.lanes.traps import LaneTraps
from rattle_kernels.model.contact import slow_part
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_NOT_CONVERGED, OUTCOME_PERMANENT_CONTACT, OUTCOME_RETURNED
from rattle_kernels.numerics.jit import inlined, lane_kernel
from rattle_kernels.numerics.pausing import Pause

_DONE_BEFORE = float(LONGEST_SHORT_RUN)
_FIRST_CHECKPOINT = _DONE_BEFORE + 1.0
_NO_POINT = -1.0
_NOT_BEGUN = -1
# Flights of all lanes between two pauses, about a microsecond each: a tenth of a second. A careful flight of one lane
# takes as long, and counts as one.
_FLIGHTS_A_LEG = 1 << 16


class _Flights(NamedTuple):
    """What a run goes on from after a pause: lanes, corners of their guesses, and counts of `_run_lanes`."""

    lanes: np.ndarray
    corners: np.ndarray
    counts: np.ndarray


@inlined
def _refill(lanes, i, rules, first_look, batch, point):
    """Give lane i the next point, or let it idle; return the point after it."""
    if point < batch.t.size:
        depart(lanes, i, batch.t[point], batch.v[point])
        begin_run(lanes, i, point, rules.applications, _FIRST_CHECKPOINT, first_look)
        lanes[DONE + i], lanes[LOWER_IMPACTS + i] = _DONE_BEFORE, batch.lower_impacts[point]
        return point + 1
    begin_run(lanes, i, _NO_POINT, math.inf, math.inf, math.inf)
    return point


@inlined
def _keep_idle(lanes, largest_grazing_speed):
    """Let lanes without a point depart anew."""
    for i in range(LANES):
        if lanes[POINT + i] == _NO_POINT:
            idle(lanes, i, largest_grazing_speed)


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
    return lanes[DONE + i] - _DONE_BEFORE


@lane_kernel
def _fly_leg(oscillator, tables, traps, rules, batch, flights):
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
            next_point = _refill(lanes, i, rules, first_look, batch, next_point)
            flying += 1 if lanes[POINT + i] != _NO_POINT else 0
    stiff, radian, slow = math.isfinite(oscillator.stiffness), ringing_radian(oscillator), slow_part(oscillator)
    nearest, top = traps.nearest, traps.top
    done = 0.0
    left = _FLIGHTS_A_LEG
    while flying > 0 and left > 0:
        if next_point == batch.t.size:
            _keep_idle(lanes, tables.largest_grazing_speed)
        carefully = fly(lanes, corners, oscillator, tables)
        if stiff:
            carefully += stay(lanes, corners, oscillator, tables, slow)
        careful += carefully
        left -= 1 + carefully
        if note_events(lanes, rules.capture_bound, radian, rules.lock_tolerance, tables.largest_grazing_speed) == 0:
            continue
        flying = 0
        for i in range(LANES):
            if lanes[POINT + i] == _NO_POINT:
                continue
            far = lanes[EVENT + i] == NOTHING or is_far(lanes, i, nearest, top)
            if not far and settles(lanes, i, traps):
                done += _land(lanes, i, batch)
                next_point = _refill(lanes, i, rules, first_look, batch, next_point)
            flying += 1 if lanes[POINT + i] != _NO_POINT else 0
    flights.lanes[:], flights.corners[:] = lanes, corners
    flights.counts[0], flights.counts[1], flights.counts[2] = next_point, flying, careful
    flights.counts[3] += int(done)


def run_long(
    oscillator: Oscillator, tables: LaneTables | LooseTables, traps: LaneTraps, rules: Rules, batch: Batch, pause: Pause
) -> LaneRun:
    """Apply P to points that have behind them what a short run may do.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    tables : LaneTables or LooseTables
    traps : LaneTraps
    rules : Rules
    batch : Batch
        Departures after LONGEST_SHORT_RUN applications. They become where they land.
    pause : callable
        Called several times a second.

    Returns
    -------
    LaneRun
    """
    flights = _Flights(np.zeros(RUN_FIELDS * LANES), np.zeros(LANES, np.int64), np.array([0, _NOT_BEGUN, 0, 0]))
    while flights.counts[1] != 0:
        pause()
        _fly_leg(oscillator, tables, traps, rules, batch, flights)
    return LaneRun(int(flights.counts[3]), int(flights.counts[2]))
