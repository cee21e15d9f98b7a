"""Lanes whose position is checked after every application of P: have they arrived, or which boxes do they pass.

The flights are those of `run`, to the bit. A lane is checked after each return and takes the next point as soon as it
has arrived. So many points are followed at about the speed of the map itself, and a single point needs no Python call
per impact.
"""

import math

import numpy as np

from rattle_kernels.impact_map.chatter import is_captured, ringing_radian
from rattle_kernels.lanes.advance import begin_at_the_end, depart, fly, idle, stay
from rattle_kernels.lanes.lane_fields import DROPS, FLIGHT_FIELDS, LANES, PHASE, VELOCITY, lane_buffer
from rattle_kernels.lanes.short_run import LONGEST_SHORT_RUN
from rattle_kernels.lanes.shortcuts import (
    CAPTURED,
    DONE,
    EVENT,
    LOST,
    NOTHING,
    POINT,
    RUN_FIELDS,
    begin_run,
    note_events,
    settles,
)
from rattle_kernels.model.contact import slow_part
from rattle_kernels.numerics.jit import always_inlined, inlined, lane_kernel
from rattle_kernels.numerics.phase import part_turn

BOXES = 2048
ELLIPSE_COLUMNS = 512
UNMARKED = -1
_ARRIVAL_STREAK = 24
_NOT_ARRIVED = -1
_NOBODY = -1
_NO_POINT = -1.0
_FIRST_CHECKPOINT = float(LONGEST_SHORT_RUN + 1)


@inlined
def box_of(largest_grazing_speed, t, v):
    """Row (a float) and column of a departure on the lattice of BOXES to a period and to the largest grazing speed."""
    return v / largest_grazing_speed * BOXES, int(t * BOXES)


@inlined
def _owner_of_ellipse(around, t, v):
    """Periodic orbit that has an ellipse around a departure; _NOT_ARRIVED for none."""
    column = min(int(t * ELLIPSE_COLUMNS), ELLIPSE_COLUMNS - 1)
    for place in range(around.first_ellipse[column], around.first_ellipse[column + 1]):
        j = around.ellipse[place]
        dt = part_turn(t - around.centre[j, 0])
        dv = v - around.centre[j, 1]
        if around.form[j, 0] * dt * dt + 2.0 * around.form[j, 1] * dt * dv + around.form[j, 2] * dv * dv <= 1.0:
            return around.owner[j]
    return _NOT_ARRIVED


@inlined
def _owner_of_box(around, t, v):
    """Chaotic attractor that has marked the box of a departure; negative where none or several have."""
    row, column = box_of(around.largest_grazing_speed, t, v)
    # Compared before it is cast: no integer holds any speed.
    return around.box_owner[int(row), column] if row < around.box_owner.shape[0] else UNMARKED


@inlined
def _look(oscillator, bound, around, lane, streak, candidate, t, v):
    """Attractor at which a lane has arrived, 0 for permanent contact; _NOT_ARRIVED for none."""
    if is_captured(oscillator, bound, t, v):
        return 0
    place = _owner_of_ellipse(around, t, v)
    if place >= 0:
        return place
    hit = _owner_of_box(around, t, v)
    streak[lane] = streak[lane] + 1 if hit >= 0 and hit == candidate[lane] else (1 if hit >= 0 else 0)
    candidate[lane] = hit
    return hit if streak[lane] >= _ARRIVAL_STREAK else _NOT_ARRIVED


@always_inlined
def _advance(lanes, corners, oscillator, tables, stiff, slow):
    """Move every lane to the end of a flight and of the contact after it."""
    fly(lanes, corners, oscillator, tables)
    if stiff:
        stay(lanes, corners, oscillator, tables, slow)
    begin_at_the_end(lanes)


@lane_kernel
def follow(oscillator, tables, around, looks, t, v, place):
    """Follow points until they have arrived at an attractor, or have been checked a number of times.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    tables : LaneTables
    around : Neighbourhoods
    looks : int
        Checks of each point, at least 1: the first is of the point itself.
    t, v : ndarray of float64, shape (n,)
        Departures from +beta. They become the last departure that was checked, NaN where a root-finder gave up.
    place : ndarray of int64, shape (n,)
        Becomes the index of the attractor, 0 for permanent contact. It stays negative where a point arrived at none.
    """
    lanes, corners = lane_buffer(FLIGHT_FIELDS), np.zeros(LANES, np.int64)
    point, looked = np.full(LANES, _NOBODY), np.zeros(LANES, np.int64)
    streak, candidate = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    stiff, slow = math.isfinite(oscillator.stiffness), slow_part(oscillator)
    next_point, flying = 0, LANES
    for i in range(LANES):
        idle(lanes, i, tables.largest_grazing_speed)
    while flying > 0:
        flying = 0
        for i in range(LANES):
            if point[i] != _NOBODY and lanes[DROPS + i] != 0.0 and lanes[PHASE + i] == lanes[PHASE + i]:
                flying += 1
                continue
            while point[i] != _NOBODY or next_point < t.size:
                if point[i] == _NOBODY:
                    point[i], looked[i], streak[i], candidate[i] = next_point, 0, 0, UNMARKED
                    depart(lanes, i, t[next_point], v[next_point])
                    next_point += 1
                at, phase, speed = point[i], lanes[PHASE + i], -lanes[VELOCITY + i]
                looked[i] += 1
                if speed == 0.0:  # a contact that does not end
                    place[at] = 0
                elif phase == phase:
                    place[at] = _look(oscillator, tables.capture_bound, around, i, streak, candidate, phase, speed)
                if place[at] < 0 and looked[i] < looks and phase == phase:
                    flying += 1
                    break
                t[at], v[at] = phase, speed
                point[i] = _NOBODY
            if point[i] == _NOBODY:
                idle(lanes, i, tables.largest_grazing_speed)
        if flying > 0:
            _advance(lanes, corners, oscillator, tables, stiff, slow)


@inlined
def _box_number(lanes, i, largest_grazing_speed):
    up, column = box_of(largest_grazing_speed, lanes[PHASE + i], -lanes[VELOCITY + i])
    return int(up) * BOXES + column


@always_inlined
def _note_boxes(lanes, largest_grazing_speed, images, first_note, here, place, box):
    """Note the box of every lane that departs now and goes on.

    Selects and stores, no branch: the last number of `box` takes the boxes of the other lanes.
    """
    nowhere = box.size - 1
    for i in range(LANES):
        here[i] = _box_number(lanes, i, largest_grazing_speed)
        done = lanes[DONE + i]
        goes_on = (lanes[EVENT + i] != LOST) & (lanes[VELOCITY + i] != 0.0) & (lanes[POINT + i] != _NO_POINT)
        noted = (lanes[DROPS + i] == 0.0) & goes_on & (done < images)
        place[i] = first_note[i] + int(done) if noted else nowhere
    for i in range(LANES):
        box[place[i]] = here[i]


@inlined
def _begin_leg(lanes, i, point, departure, rules, largest_grazing_speed, visit, notes):
    """Let lane i depart on a leg; note where, and the first box. The others of the leg are still missing."""
    begin_run(lanes, i, point, rules.applications, _FIRST_CHECKPOINT, math.inf)
    visit[0], visit[1] = departure
    depart(lanes, i, visit[0], visit[1])
    notes[:] = UNMARKED
    notes[0] = _box_number(lanes, i, largest_grazing_speed)


@lane_kernel
def boxes_passed(oscillator, tables, rules, traps, t, v, returned, row, visits, box):
    """Apply P to points as `run.run_lanes` does, to the bit, leg by leg, and note the boxes in which they depart.

    A lane begins its next leg at once, whatever leg the others are on.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    tables : LaneTables
    rules : Rules
        Of each leg.
    traps : LaneTraps
        NO_TRAPS.
    t, v : ndarray of float64, shape (n,)
        Departures from +beta. They become where those land that return.
    returned : ndarray of bool, shape (n,)
        Becomes whether a point has done all legs, and was not captured or lost before.
    row : ndarray of int64, shape (n,)
        Row of `visits` and `box` for each point.
    visits : ndarray of float64, shape (legs, 2, rows)
        Becomes phase and speed at the beginning of each leg that a point begins.
    box : ndarray of int64, shape (legs * rows * images + 1,)
        For each leg and row becomes row times BOXES plus column of the departures of the leg, its first one first; -1
        after an end or a lock. The last number means nothing.
    """
    lanes, corners = lane_buffer(RUN_FIELDS), np.zeros(LANES, np.int64)
    here, place, first_note = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    leg = np.zeros(LANES, np.int64)
    stiff, radian, slow = math.isfinite(oscillator.stiffness), ringing_radian(oscillator), slow_part(oscillator)
    top = tables.largest_grazing_speed
    legs, _, rows = visits.shape
    images = box.size // (legs * rows)
    for first in range(0, t.size, LANES):
        flying = min(LANES, t.size - first)
        for i in range(LANES):
            begin_run(lanes, i, _NO_POINT, math.inf, math.inf, math.inf)
        for i in range(flying):
            at, leg[i], first_note[i] = first + i, 0, row[first + i] * images
            notes = box[first_note[i] : first_note[i] + images]
            _begin_leg(lanes, i, float(at), (t[at], v[at]), rules, top, visits[0, :, row[at]], notes)
        while flying > 0:
            for i in range(LANES):
                if lanes[POINT + i] == _NO_POINT:
                    idle(lanes, i, top)
            fly(lanes, corners, oscillator, tables)
            if stiff:
                stay(lanes, corners, oscillator, tables, slow)
            events = note_events(lanes, rules.capture_bound, radian, rules.lock_tolerance, top)
            _note_boxes(lanes, top, images, first_note, here, place, box)
            if events == 0:
                continue
            for i in range(LANES):
                if lanes[POINT + i] == _NO_POINT or lanes[EVENT + i] == NOTHING or not settles(lanes, i, traps):
                    continue
                at = first + i
                t[at], v[at] = lanes[PHASE + i], -lanes[VELOCITY + i]
                returned[at] = lanes[EVENT + i] != CAPTURED and lanes[EVENT + i] != LOST
                leg[i] += 1
                if returned[at] and leg[i] < legs:
                    first_note[i] += rows * images
                    notes = box[first_note[i] : first_note[i] + images]
                    _begin_leg(lanes, i, float(at), (t[at], v[at]), rules, top, visits[leg[i], :, row[at]], notes)
                else:
                    begin_run(lanes, i, _NO_POINT, math.inf, math.inf, math.inf)
                    flying -= 1
