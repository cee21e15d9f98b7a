"""Lanes that look where they are after every application of P: have they arrived, or which boxes do they pass.

The flights are those of `impact_lanes`, to the bit. A lane looks after each return and takes the next point as soon as
it has arrived: many points are followed at about the speed of the map itself, and one alone costs no call an impact.
"""

import math

import numpy as np

from rattle_kernels.impact_map.chatter import is_captured
from rattle_kernels.lanes.contact import guess_stays, refine_stays, stay_carefully
from rattle_kernels.lanes.flight import (
    DROPS,
    END_PHASE,
    END_VELOCITY,
    FLIGHT_FIELDS,
    LANES,
    PHASE,
    VELOCITY,
    fly_carefully,
    guess_durations,
    lane_buffer,
    refine_durations,
)
from rattle_kernels.model.contact import slow_part
from rattle_kernels.numerics.jit import inlined, lane_kernel

BOXES = 2048
ELLIPSE_COLUMNS = 512
UNMARKED = -1
_ARRIVAL_STREAK = 24
_NOT_ARRIVED = -1
_NOBODY = -1


@inlined
def box_of(speed_scale, t, v):
    """Row and column of a departure on the lattice of BOXES to a period and to the natural speed; the row as float."""
    return v / speed_scale * BOXES, int(t * BOXES)


@inlined
def _owner_of_ellipse(around, t, v):
    """Periodic orbit in one of whose ellipses a departure lies, or none."""
    column = min(int(t * ELLIPSE_COLUMNS), ELLIPSE_COLUMNS - 1)
    for place in range(around.first_ellipse[column], around.first_ellipse[column + 1]):
        j = around.ellipse[place]
        dt = t - around.centre[j, 0]
        dt -= np.floor(dt + 0.5)
        dv = v - around.centre[j, 1]
        if around.form[j, 0] * dt * dt + 2.0 * around.form[j, 1] * dt * dv + around.form[j, 2] * dv * dv <= 1.0:
            return around.owner[j]
    return _NOT_ARRIVED


@inlined
def _owner_of_box(around, t, v):
    """Chaotic attractor that has marked the box of a departure; negative where none has, or several have."""
    row, column = box_of(around.speed_scale, t, v)
    # Compared before it is cast: no integer holds any speed.
    return around.box_owner[int(row), column] if row < around.box_owner.shape[0] else UNMARKED


@inlined
def _look(oscillator, bound, around, lane, streak, candidate, t, v):
    """Attractor that lane `lane` has arrived at, 0 for permanent contact; or that it has not."""
    if is_captured(oscillator, bound, t, v):
        return 0
    place = _owner_of_ellipse(around, t, v)
    if place >= 0:
        return place
    hit = _owner_of_box(around, t, v)
    streak[lane] = streak[lane] + 1 if hit >= 0 and hit == candidate[lane] else (1 if hit >= 0 else 0)
    candidate[lane] = hit
    return hit if streak[lane] >= _ARRIVAL_STREAK else _NOT_ARRIVED


@inlined
def _fly(lanes, corners, oscillator, tables, stiff, slow):
    """A flight of every lane, and the stay in contact after it; its end becomes the state."""
    guess_durations(lanes, corners, tables, 2.0 * oscillator.half_backlash)
    if refine_durations(lanes, oscillator.damping, oscillator.eccentricity) > 0:
        fly_carefully(lanes, oscillator)
    if stiff:
        guess_stays(lanes, corners, tables)
        if refine_stays(lanes, oscillator.damping, slow) > 0:
            stay_carefully(lanes, oscillator)
    for i in range(LANES):
        lanes[PHASE + i] = lanes[END_PHASE + i]
        lanes[VELOCITY + i] = lanes[END_VELOCITY + i]


@inlined
def _depart(lanes, lane, phase, speed):
    lanes[PHASE + lane] = phase - math.floor(phase)
    lanes[VELOCITY + lane] = -speed


@inlined
def _idle(lanes, lane, speed_scale):
    """Fly at a speed at which a lane is never unsure."""
    _depart(lanes, lane, 0.0, 1e6 * speed_scale)


@lane_kernel
def follow(oscillator, tables, around, looks, t, v, place):
    """Follow points until they have arrived at an attractor, or have been looked at so many times.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    tables : LaneTables
    around : Neighbourhoods
    looks : int
        At least 1: the first look is at the point itself.
    t, v : ndarray of float64, shape (n,)
        Departures from +beta; become where the points are that have not arrived, NaN where a root-finder gave up.
    place : ndarray of int64, shape (n,)
        Becomes the index of the attractor, 0 for permanent contact, -1 where it arrived at none.
    """
    lanes, corners = lane_buffer(FLIGHT_FIELDS), np.zeros(LANES, np.int64)
    point, looked = np.full(LANES, _NOBODY), np.zeros(LANES, np.int64)
    streak, candidate = np.zeros(LANES, np.int64), np.zeros(LANES, np.int64)
    stiff, slow = math.isfinite(oscillator.stiffness), slow_part(oscillator)
    following, flying = 0, LANES
    for i in range(LANES):
        _idle(lanes, i, tables.speed_scale)
    while flying > 0:
        flying = 0
        for i in range(LANES):
            if point[i] != _NOBODY and lanes[DROPS + i] != 0.0 and lanes[PHASE + i] == lanes[PHASE + i]:
                flying += 1
                continue
            while point[i] != _NOBODY or following < t.size:
                if point[i] == _NOBODY:
                    point[i], looked[i], streak[i], candidate[i] = following, 0, 0, UNMARKED
                    _depart(lanes, i, t[following], v[following])
                    following += 1
                at, phase, speed = point[i], lanes[PHASE + i], -lanes[VELOCITY + i]
                looked[i] += 1
                if speed == 0.0:  # a stay that does not end
                    place[at] = 0
                elif phase == phase:
                    place[at] = _look(oscillator, tables.capture_bound, around, i, streak, candidate, phase, speed)
                if place[at] < 0 and looked[i] < looks and phase == phase:
                    flying += 1
                    break
                t[at], v[at] = phase, speed
                point[i] = _NOBODY
            if point[i] == _NOBODY:
                _idle(lanes, i, tables.speed_scale)
        if flying > 0:
            _fly(lanes, corners, oscillator, tables, stiff, slow)


@lane_kernel
def boxes_passed(oscillator, tables, t, v, box):
    """Numbers of the boxes in which points and their next images lie.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    tables : LaneTables
    t, v : ndarray of float64, shape (n,)
        Departures from +beta of motions that rattle for ever.
    box : ndarray of int64, shape (n, images)
        Becomes row times BOXES plus column of each departure, the points themselves first; -1 after an end.
    """
    lanes, corners = lane_buffer(FLIGHT_FIELDS), np.zeros(LANES, np.int64)
    stiff, slow = math.isfinite(oscillator.stiffness), slow_part(oscillator)
    box[:] = UNMARKED
    passed = np.zeros(LANES, np.int64)
    for first in range(0, t.size, LANES):
        crowd = min(LANES, t.size - first)
        passed[:] = 0
        for i in range(LANES):
            _idle(lanes, i, tables.speed_scale)
            lanes[DROPS + i] = 0.0
            if i < crowd:
                _depart(lanes, i, t[first + i], v[first + i])
        flying = crowd
        while flying > 0:
            flying = 0
            for i in range(crowd):
                goes_on = lanes[PHASE + i] == lanes[PHASE + i] and lanes[VELOCITY + i] != 0.0
                if passed[i] < box.shape[1] and lanes[DROPS + i] == 0.0 and goes_on:
                    row, column = box_of(tables.speed_scale, lanes[PHASE + i], -lanes[VELOCITY + i])
                    box[first + i, passed[i]] = int(row) * BOXES + column
                    passed[i] += 1
                flying += 1 if passed[i] < box.shape[1] and goes_on else 0
            if flying > 0:
                _fly(lanes, corners, oscillator, tables, stiff, slow)
