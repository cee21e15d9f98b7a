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
from rattle_kernels.lanes.flight import (
    DROPS,
    END_ACCELERATION,
    END_PHASE,
    END_VELOCITY,
    FLIGHT_FIELDS,
    LANES,
    PHASE,
    VELOCITY,
    lane_buffer,
)
from rattle_kernels.lanes.tables import LaneTables
from rattle_kernels.model.contact import slow_part
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import (
    OUTCOME_NOT_CONVERGED,
    OUTCOME_OUTSIDE_SECTION,
    OUTCOME_PERMANENT_CONTACT,
    OUTCOME_RETURNED,
)
from rattle_kernels.numerics.jit import inlined, lane_kernel
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

LONGEST_SHORT_RUN = 15
"""Applications of P before the first checkpoint."""

# Applications of P between two pauses: a tenth of a second, or some tenths where the careful path is common.
_APPLICATIONS_A_LEG = 1 << 22
# Points that fly by turns: what is kept of them fits into the second-level cache.
_CHUNK = 4096


@inlined
def _wait_to_depart(batch, first, last, waiting):
    """List the departures among some points; the others get their outcome. Velocities become signed."""
    t, v = batch.t, batch.v
    count = 0
    for point in range(first, last):
        departs = math.isfinite(t[point]) and math.isfinite(v[point]) and v[point] > 0.0
        t[point] = wrap(t[point]) if departs else math.nan
        v[point] = -v[point] if departs else math.nan
        batch.outcome[point] = OUTCOME_OUTSIDE_SECTION
        waiting[count] = point
        count += 1 if departs else 0
    return count


@inlined
def _load(lanes, batch, left, waiting, head, first, count, largest_grazing_speed):
    """Give the lanes the next points that wait; lanes without one idle."""
    for i in range(count):
        point = waiting[head + i]
        lanes[PHASE + i], lanes[VELOCITY + i] = batch.t[point], batch.v[point]
        lanes[_LEFT + i] = left[point - first]
    for i in range(count, LANES):
        idle(lanes, i, largest_grazing_speed)


@inlined
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
        ended = outcome != _ON_THE_WAY
        speed = -velocity if velocity != 0.0 else math.nan
        end_velocity = speed if ended else velocity
        end_velocity = math.nan if outcome == _NOT_CONVERGED else end_velocity
        lanes[_LEFT + i], lanes[_OUTCOME + i] = left, outcome
        # A sum, so that a phase is NaN where the speed is.
        lanes[PHASE + i] = phase + (end_velocity - end_velocity)
        lanes[VELOCITY + i] = end_velocity


@inlined
def _write_down(lanes, batch, left, waiting, head, first, count, tail):
    """Write down where the points of the lanes are, and let those that have not landed wait; return how many wait."""
    for i in range(count):
        point = waiting[head + i]
        batch.t[point], batch.v[point] = lanes[PHASE + i], lanes[VELOCITY + i]
        batch.lower_impacts[point] += np.int64(lanes[DROPS + i])
        batch.outcome[point] = np.int8(lanes[_OUTCOME + i])
        left[point - first] = lanes[_LEFT + i]
        waiting[tail] = point
        tail += 1 if lanes[_OUTCOME + i] == _ON_THE_WAY else 0
    return tail


@lane_kernel
def _fly_leg(oscillator, tables, rules, batch, first, last):
    """Fly the points from `first` to the one before `last`; return applications and careful flights and contacts."""
    lanes, corners = lane_buffer(_FIELDS), np.zeros(LANES, np.int64)
    waiting, left = np.zeros(_CHUNK, np.uint32), np.zeros(_CHUNK)
    stiff, radian, slow = math.isfinite(oscillator.stiffness), ringing_radian(oscillator), slow_part(oscillator)
    flights, careful = 0, 0
    for begin in range(first, last, _CHUNK):
        left[:] = rules.applications
        flying = _wait_to_depart(batch, begin, min(begin + _CHUNK, last), waiting)
        while flying > 0:
            tail = 0
            for head in range(0, flying, LANES):
                count = min(LANES, flying - head)
                _load(lanes, batch, left, waiting, head, begin, count, tables.largest_grazing_speed)
                careful += fly(lanes, corners, oscillator, tables)
                if stiff:
                    careful += stay(lanes, corners, oscillator, tables, slow)
                _decide(lanes, rules.capture_bound, radian)
                flights += count
                tail = _write_down(lanes, batch, left, waiting, head, begin, count, tail)
            flying = tail
    # Each application ends with a flight to +beta; the other flights are those to -beta.
    return flights - batch.lower_impacts[first:last].sum(), careful


def run_short(oscillator: Oscillator, tables: LaneTables, rules: Rules, batch: Batch, pause: Pause) -> LaneRun:
    """Apply P to points, at most LONGEST_SHORT_RUN times.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    tables : LaneTables
    rules : Rules
    batch : Batch
        Its points become where they land.
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
        run = _fly_leg(oscillator, tables, rules, batch, first, min(first + points, batch.t.size))
        applications, careful = applications + run[0], careful + run[1]
    return LaneRun(applications, careful)
