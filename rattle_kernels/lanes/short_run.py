"""Short runs: up to 15 applications of P to many points.

No checkpoint is set before the 16th application, so no point locks, and none is looked at (`shortcuts`): it lands when
its applications are done, or where it is captured or lost. Batches of 64 points depart together and fly once. Points
that have not landed wait for the next pass, so batches stay full. A point costs some loads and stores a flight. In a
long run a lane takes its next point alone, which costs as much as 30 applications.
"""

import math

import numpy as np

from rattle_kernels.impact_map.chatter import is_below, ringing_radian
from rattle_kernels.lanes.advance import fly, idle, stay
from rattle_kernels.lanes.batch import Batch, LaneRun, Rules
from rattle_kernels.lanes.lane_fields import (
    DROPS,
    END_ACCELERATION,
    END_PHASE,
    END_VELOCITY,
    FLIGHT_FIELDS,
    IDLE_SPEED,
    LANES,
    PHASE,
    VELOCITY,
    lane_buffer,
)
from rattle_kernels.lanes.tables import LaneTables, LooseTables
from rattle_kernels.model.contact import slow_part
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import (
    OUTCOME_NOT_CONVERGED,
    OUTCOME_OUTSIDE_SECTION,
    OUTCOME_PERMANENT_CONTACT,
    OUTCOME_RETURNED,
)
from rattle_kernels.numerics.jit import always_inlined, lane_kernel
from rattle_kernels.numerics.pausing import Pause
from rattle_kernels.numerics.phase import wrap

# Fields of the buffer beside those of a flight.
_LEFT = (FLIGHT_FIELDS + 0) * LANES
_OUTCOME = (FLIGHT_FIELDS + 1) * LANES
_FIELDS = FLIGHT_FIELDS + 2
_ON_THE_WAY = -1.0

_RETURNED = float(OUTCOME_RETURNED)
_PERMANENT_CONTACT = float(OUTCOME_PERMANENT_CONTACT)
_NOT_CONVERGED = float(OUTCOME_NOT_CONVERGED)
_OUTSIDE_SECTION = float(OUTCOME_OUTSIDE_SECTION)

LONGEST_SHORT_RUN = 15
"""Applications of P before the first checkpoint."""

# Applications of P between two pauses: a tenth of a second, or some tenths where the careful path is common.
_APPLICATIONS_A_LEG = 1 << 22
# Points that fly by turns: what is kept of them fits into the second-level cache.
_CHUNK = 4096


@always_inlined
def _depart(lanes, t, v, applications, largest_grazing_speed):
    """Let the lanes depart with neighbouring points; those that are no departures, and lanes without a point, idle."""
    for i in range(t.size):
        departs = (v[i] > 0.0) & (v[i] < math.inf) & (abs(t[i]) < math.inf)
        lanes[PHASE + i] = wrap(t[i]) if departs else 0.0
        lanes[VELOCITY + i] = -v[i] if departs else -IDLE_SPEED * largest_grazing_speed
        lanes[_LEFT + i] = applications if departs else math.nan
    for i in range(t.size, LANES):
        idle(lanes, i, largest_grazing_speed)


@always_inlined
def _land(lanes, t, v, outcome, lower_impacts):
    """Write down where the neighbouring points of `_depart` are."""
    for i in range(t.size):
        t[i], v[i] = lanes[PHASE + i], lanes[VELOCITY + i]
    for i in range(t.size):
        outcome[i] = np.int8(lanes[_OUTCOME + i])
    for i in range(t.size):
        lower_impacts[i] = np.int64(lanes[DROPS + i])


@always_inlined
def _load(lanes, t, v, left, points, largest_grazing_speed):
    """Give the lanes points that wait; lanes without one idle."""
    for i in range(points.size):
        point = points[i]
        lanes[PHASE + i], lanes[VELOCITY + i], lanes[_LEFT + i] = t[point], v[point], left[i]
    for i in range(points.size, LANES):
        idle(lanes, i, largest_grazing_speed)


@always_inlined
def _store(lanes, t, v, outcome, lower_impacts, points):
    """Write down where the points of `_load` are."""
    for i in range(points.size):
        point = points[i]
        t[point], v[point] = lanes[PHASE + i], lanes[VELOCITY + i]
        outcome[point] = np.int8(lanes[_OUTCOME + i])
        lower_impacts[point] += np.int64(lanes[DROPS + i])


@always_inlined
def _decide(lanes, capture_bound, radian):
    """What comes of every lane at the end of its flight: its outcome, and where it departs next or at last.

    Velocities stay signed on the way and are speeds in the end. Selects only, as in `flight`.
    """
    for i in range(LANES):
        phase, velocity, drops = lanes[END_PHASE + i], lanes[END_VELOCITY + i], lanes[DROPS + i]
        left = lanes[_LEFT + i] - (1.0 - drops)
        outcome = _RETURNED if left <= 0.0 else _ON_THE_WAY
        captured = is_below(capture_bound, radian, lanes[END_ACCELERATION + i], -velocity)
        outcome = _PERMANENT_CONTACT if captured else outcome
        outcome = _PERMANENT_CONTACT if velocity == 0.0 else outcome  # a contact that does not end
        outcome = outcome if drops == 0.0 else _ON_THE_WAY
        outcome = outcome if phase == phase else _NOT_CONVERGED  # NaN: a root-finder gave up
        outcome = outcome if left == left else _OUTSIDE_SECTION
        ended = outcome != _ON_THE_WAY
        speed = -velocity if velocity != 0.0 else math.nan
        end_velocity = speed if ended else velocity
        end_velocity = end_velocity if outcome < _NOT_CONVERGED else math.nan
        lanes[DROPS + i] = drops if left == left else 0.0
        lanes[_LEFT + i], lanes[_OUTCOME + i] = left, outcome
        # A sum, so that a phase is NaN where the speed is.
        lanes[PHASE + i] = phase + (end_velocity - end_velocity)
        lanes[VELOCITY + i] = end_velocity


@always_inlined
def _list_those_on_the_way(lanes, points, waiting, left, tail):
    """Add the points of the lanes that have not landed to those that wait; return how many wait."""
    for i in range(points.size):
        waiting[tail], left[tail] = points[i], lanes[_LEFT + i]
        tail += 1 if lanes[_OUTCOME + i] == _ON_THE_WAY else 0
    return tail


@lane_kernel
def _fly_leg(oscillator, tables, rules, departures, batch, first, last):
    """Fly the points from `first` to the one before `last`; return applications and careful flights and contacts."""
    lanes, corners = lane_buffer(_FIELDS), np.zeros(LANES, np.int64)
    size = min(_CHUNK, last - first)
    numbers, waiting, left = np.arange(size).astype(np.uint32), np.zeros(size, np.uint32), np.zeros(size)
    stiff, radian, slow = math.isfinite(oscillator.stiffness), ringing_radian(oscillator), slow_part(oscillator)
    flights, careful, top = 0, 0, tables.largest_grazing_speed
    for begin in range(first, last, _CHUNK):
        end = min(begin + _CHUNK, last)
        t0, v0 = departures[0][begin:end], departures[1][begin:end]
        t, v = batch.t[begin:end], batch.v[begin:end]
        outcome, lower_impacts = batch.outcome[begin:end], batch.lower_impacts[begin:end]
        flying, departed = t.size, False
        while flying > 0:
            tail = 0
            for head in range(0, flying, LANES):
                stop = min(head + LANES, flying)
                points = waiting[head:stop] if departed else numbers[head:stop]
                if departed:
                    _load(lanes, t, v, left[head:stop], points, top)
                else:
                    _depart(lanes, t0[head:stop], v0[head:stop], rules.applications, top)
                careful += fly(lanes, corners, oscillator, tables)
                if stiff:
                    careful += stay(lanes, corners, oscillator, tables, slow)
                _decide(lanes, rules.capture_bound, radian)
                if departed:
                    _store(lanes, t, v, outcome, lower_impacts, points)
                else:
                    own = slice(head, stop)
                    _land(lanes, t[own], v[own], outcome[own], lower_impacts[own])
                tail = _list_those_on_the_way(lanes, points, waiting, left, tail)
            flights += flying
            flying, departed = tail, True
    # Each application ends with a flight to +beta. The other flights are those to -beta, and of lanes that idled.
    idled = (batch.outcome[first:last] == OUTCOME_OUTSIDE_SECTION).sum()
    return flights - batch.lower_impacts[first:last].sum() - idled, careful


def run_short(
    oscillator: Oscillator,
    tables: LaneTables | LooseTables,
    rules: Rules,
    departures: tuple[np.ndarray, np.ndarray],
    batch: Batch,
    pause: Pause,
) -> LaneRun:
    """Apply P to points, at most LONGEST_SHORT_RUN times.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    tables : LaneTables or LooseTables
    rules : Rules
    departures : tuple of ndarray, each of shape (n,)
        Phases and speeds.
    batch : Batch
        Of the same size; where the departures land.
    pause : callable
        Called several times a second.

    Returns
    -------
    LaneRun
    """
    applications, careful = 0, 0
    points = _APPLICATIONS_A_LEG // int(rules.applications)
    for first in range(0, batch.t.size, points):
        pause()
        run = _fly_leg(oscillator, tables, rules, departures, batch, first, min(first + points, batch.t.size))
        applications, careful = applications + run[0], careful + run[1]
    return LaneRun(applications, careful)
