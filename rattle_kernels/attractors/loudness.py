"""How loud a motion is: impacts a forcing period, the largest impact speed, and the power of the impacts.

An impact is an arrival at a wall, on +beta or on -beta, and its speed v_i is that of arrival. In the piecewise linear
model it is a contact, and v_i is the speed of entering it. The power of the impacts is ``sum v_i^2 / (2 m)`` over the
impacts of m forcing periods: the kinetic energy a period that walls turn round. An elastic wall gives all of it back;
one with restitution r keeps the part 1 - r^2.

A periodic orbit is followed once around, each departure to the next one, so no error grows along it. Chaos is followed
from 512 of the departures in its catalogue. Their scatter gives the error of the means, as it does for the Lyapunov
exponent. The largest speed has no error: it is the largest that was met, and a longer stretch may meet a larger one.
Permanent contact has no impacts.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import Attractor, AttractorKind
from rattle_kernels.impact_map.chatter import is_captured
from rattle_kernels.lanes.advance import begin_at_the_end, depart, fly, idle, stay
from rattle_kernels.lanes.lane_fields import (
    DROPS,
    DURATION,
    END_VELOCITY,
    FLIGHT_FIELDS,
    LANES,
    PHASE,
    VELOCITY,
    lane_buffer,
)
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.model.contact import slow_part
from rattle_kernels.model.domain import check_domain
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import lane_kernel

# Departures from which chaos is followed, and applications from each. Departures of one trajectory lie 256 impacts or
# more apart in a catalogue: stretches shorter than that share no impact. That number is the same for all of them, so
# they may all begin in one band of chaos in several: a multiple of 2 to 6, 8, 10, 12 and 16 visits each equally often.
_STRETCHES, _APPLICATIONS = 512, 240


class Loudness(NamedTuple):
    """Severity of a motion; NaN where it is not known, as of a motion that is undecided.

    ``impacts_per_period`` counts arrivals on both walls in a forcing period. ``impact_power`` is ``sum v_i^2 / (2 m)``.
    Standard errors are 0 for a periodic orbit and for permanent contact.
    """

    impacts_per_period: float
    largest_impact_speed: float
    impact_power: float
    impacts_per_period_error: float
    impact_power_error: float


_SILENT = Loudness(0.0, 0.0, 0.0, 0.0, 0.0)
_NOT_KNOWN = Loudness(*(math.nan,) * 5)


@lane_kernel
def _listen(oscillator, tables, applications, t, v, heard):
    """Follow at most LANES departures; rows of ``heard`` become impacts, sum of squares, largest speed, and time."""
    lanes, corners = lane_buffer(FLIGHT_FIELDS), np.zeros(LANES, np.int64)
    stiff, slow = math.isfinite(oscillator.stiffness), slow_part(oscillator)
    left = np.full(t.size, applications)
    for i in range(t.size):
        depart(lanes, i, t[i], v[i])
    flying = t.size
    while flying > 0:
        for i in range(LANES):
            if i >= t.size or left[i] == 0:
                idle(lanes, i, tables.largest_grazing_speed)
        fly(lanes, corners, oscillator, tables)
        for i in range(t.size):
            if left[i] > 0:
                speed = abs(lanes[END_VELOCITY + i]) / oscillator.restitution
                heard[i, 0] += 1.0
                heard[i, 1] += speed * speed
                heard[i, 2] = max(heard[i, 2], speed)
                heard[i, 3] += lanes[DURATION + i]
        if stiff:
            stay(lanes, corners, oscillator, tables, slow)
        begin_at_the_end(lanes)
        for i in range(t.size):
            if left[i] == 0:
                continue
            heard[i, 3] += lanes[DURATION + i] if stiff else 0.0
            phase, speed = lanes[PHASE + i], -lanes[VELOCITY + i]
            if phase == phase and lanes[DROPS + i] != 0.0:
                continue
            left[i] -= 1
            goes_on = phase == phase and speed > 0.0
            if not goes_on or is_captured(oscillator, tables.capture_bound, phase, speed):
                left[i] = 0
                heard[i] = math.nan
            if left[i] == 0:
                flying -= 1


def _heard(oscillator: Oscillator, t: np.ndarray, v: np.ndarray, applications: int) -> np.ndarray:
    """What is heard from each departure on, without those that fall quiet on the way."""
    tables, heard = lane_tables(oscillator), np.zeros((t.size, 4))
    times, speeds = np.ascontiguousarray(t), np.ascontiguousarray(v)
    for first in range(0, t.size, LANES):
        batch = slice(first, first + LANES)
        _listen(oscillator, tables, applications, times[batch], speeds[batch], heard[batch])
    going: np.ndarray = heard[np.isfinite(heard[:, 3])]
    return going


def _mean(part: np.ndarray, time: np.ndarray) -> tuple[float, float]:
    """Mean a period, and its standard error from the scatter over independent stretches; NaN for a single one."""
    mean = float(part.sum() / time.sum())
    if part.size < 2:
        return mean, math.nan
    scatter = (part - mean * time) / time.mean()
    return mean, float(scatter.std(ddof=1) / math.sqrt(part.size))


def loudness(oscillator: Oscillator, attractor: Attractor) -> Loudness:
    """How loud a motion is.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    attractor : Attractor
        One of its motions, with its points.

    Returns
    -------
    Loudness
        Zeros for permanent contact. NaN for a motion without points, such as one that is undecided. Of a chaotic
        transient that of its chaos, without what follows.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.

    Examples
    --------
    >>> import math
    >>> orbit = find_attractors(Oscillator(), [0.89829], [3.76991])[1]
    >>> orbit.name, round(loudness(Oscillator(), orbit).largest_impact_speed / (2 * math.pi * 0.6), 9)
    ('P(1,1,0)', 1.0)
    """
    checked = check_domain(oscillator)
    if attractor.kind == AttractorKind.PERMANENT_CONTACT:
        return _SILENT
    points = attractor.time.size
    if not points:
        return _NOT_KNOWN
    if attractor.kind == AttractorKind.PERIODIC:
        heard = _heard(checked, attractor.time, attractor.velocity, 1)
        impacts, squares = heard[:, :2].sum(axis=0) / attractor.forcing_periods
        return Loudness(float(impacts), float(heard[:, 2].max()), 0.5 * float(squares), 0.0, 0.0)
    chosen = np.unique(np.linspace(0, points - 1, _STRETCHES).astype(np.int64))
    heard = _heard(checked, attractor.time[chosen], attractor.velocity[chosen], _APPLICATIONS)
    if not len(heard):
        return _NOT_KNOWN
    impacts, impacts_error = _mean(heard[:, 0], heard[:, 3])
    power, power_error = _mean(0.5 * heard[:, 1], heard[:, 3])
    return Loudness(impacts, float(heard[:, 2].max()), power, impacts_error, power_error)
