"""The quiet core: departures ``v^3 < level a(t)`` whose action v^3/a falls at every bounce, for ever. They fall quiet.

Boxes are tested from the lowest bounces upwards: up to some duration by `low_bounces`, above that by their images. A
box in which the action may grow puts an end to the core at the least action in it: no box of the core is unproven. On
every compact part of the core the action falls by a factor below 1 at each bounce, so it falls to 0.

Within tolerances the action itself is uncertain, more than one bounce changes it. So they are cut in parts, and the
level is the least of all parts.
"""

import heapq
import itertools
import math

import numpy as np

from rattle_kernels.numerics.jit import inlined_as_written, kernel_as_written
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_proof.enclosures.flight import Box, halves_of_part
from rattle_proof.enclosures.impact import LOST, image
from rattle_proof.enclosures.interval import Interval, divide, down, middle, multiply, point, square
from rattle_proof.enclosures.low_bounces import low_bounces
from rattle_proof.enclosures.machine import Machine, acceleration, centre_of, error_at, halves_of

PARTS = 16
"""In how many parts tolerances are cut."""
# How much of the level is claimed within tolerances. Boxes above it come below it soon, so next to nothing is lost.
# At the level itself a program that cuts tolerances otherwise has to cut them into thousands of parts.
_CLAIMED = 0.75
# Durations up to which Taylor's series serves: in periods of the highest order, and in 1/delta.
_SHORT_TURN, _SHORT_FALL = 0.3, 0.5
_STRIPS, _COLUMNS, _FINE_COLUMNS = 100, 64, 1024
# How much of itself a strip is high, of short bounces and of others.
_STEP_SHORT, _STEP = 0.15, 0.04
_MOST_STRIPS = 400
# How often a box is halved before the proof is given up.
_DEPTH = 14


@inlined_as_written
def _test_short(machine, t, tau):
    """Whether the action falls at all short bounces of a box; and the least action in it."""
    bounces = low_bounces(machine, t, tau)
    falls = bounces.growth.high < 0.0 or bounces.gain.high < 0.0
    # The formulas are those of a bounce that does not meet -beta.
    return falls and bounces.speed.high <= machine.safe_speed, bounces.action.low


@inlined_as_written
def _action(machine, t, v):
    felt = acceleration(machine, error_at(machine, t))
    return divide(multiply(square(v), v), felt)


@inlined_as_written
def _test_long(machine, oscillator, t, v):
    """Whether the action falls at all departures of a box; and the least action in it."""
    before = _action(machine, t, v)
    after = image(machine, oscillator, Box(point(middle(t)), point(middle(v))), Box(t, v))
    if after.state == LOST:
        return False, before.low
    return _action(machine, after.all.t, after.all.w).high < before.low, before.low


@inlined_as_written
def _test(machine, oscillator, short, t, other):
    return _test_short(machine, t, other) if short else _test_long(machine, oscillator, t, other)


@kernel_as_written
def _lowest_failure(machine, oscillator, short, t, other, level, stack):
    """Least action of the boxes within one that cannot be proven, of those below `level`; else `level`."""
    stack[0] = t.low, t.high, other.low, other.high, 0.0
    waiting = 1
    while waiting > 0:
        waiting -= 1
        box = stack[waiting, 0], stack[waiting, 1], stack[waiting, 2], stack[waiting, 3], stack[waiting, 4]
        falls, least = _test(machine, oscillator, short, Interval(box[0], box[1]), Interval(box[2], box[3]))
        if falls or least >= level:
            continue
        if box[4] >= _DEPTH:
            level = least if least > 0.0 else 0.0
            continue
        # The later or upper half waits: the other may lower the level first.
        stack[waiting], stack[waiting + 1] = halves_of_part(box)
        waiting += 2
    return level


def _columns(count: int) -> list[Interval]:
    return [Interval(i / count, (i + 1) / count) for i in range(count)]


@kernel_as_written
def _slowest(machine, tau, phases):
    """Least speed of all departures that last this long; 0 if it is not known."""
    least = math.inf
    for i in range(phases):
        speed = low_bounces(machine, Interval(i / phases, (i + 1) / phases), point(tau)).speed.low
        if not speed > 0.0:
            return 0.0
        least = min(least, speed)
    return least


def quiet_level(machine: Machine, fastest: float, parts: int = PARTS, pause: Pause = never_stopped) -> float:
    """A level such that every departure ``v^3 < level a(t)`` is proven to fall quiet: the largest found.

    Within tolerances it is three quarters of that.

    Parameters
    ----------
    machine : Machine
    fastest : float
        Speed beyond which no core is sought. Where all motions fall quiet, the action falls at every speed.
    parts : int
        In how many parts tolerances are cut at most.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    float
        0 if nothing is proven.
    """
    number = itertools.count()
    levels = [(level_of(machine, fastest, pause), next(number), machine)]
    while len(levels) < parts:
        # The part with the least level, which is the level of all.
        halves = halves_of(levels[0][2])
        if not halves:
            break
        heapq.heappop(levels)
        for half in halves:
            heapq.heappush(levels, (level_of(half, fastest, pause), next(number), half))
    return levels[0][0] if machine.exact else down(_CLAIMED * levels[0][0])


def level_of(machine: Machine, fastest: float, pause: Pause = never_stopped) -> float:
    """The largest level found of machines within tolerances that are not cut.

    Parameters
    ----------
    machine : Machine
    fastest : float
        Speed beyond which no core is sought.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    float
        0 if nothing is proven.
    """
    oscillator = centre_of(machine)
    stack = np.empty((_DEPTH + 2, 5))
    highest = float(machine.harmonics[:, 0].max())
    short = min(_SHORT_TURN / highest, _SHORT_FALL / machine.damping.high)
    level = math.inf
    begin = 0.0
    for i in range(_STRIPS, -1, -1):
        end = short * (1.0 + _STEP_SHORT) ** -i
        for t in _columns(_COLUMNS):
            pause()
            level = _lowest_failure(machine, oscillator, True, t, Interval(begin, end), level, stack)
        begin = end
    weakest = min(acceleration(machine, error_at(machine, t)).low for t in _columns(_FINE_COLUMNS))
    enough = fastest**3 / weakest
    # A faster departure takes longer: up to this speed all bounces are short.
    low = _slowest(machine, short, _FINE_COLUMNS)
    if low == 0.0:
        return 0.0
    for _ in range(_MOST_STRIPS):
        least = down(down(low * low * low) / machine.greatest_acceleration)
        if not least < level:
            return level
        if least > enough:
            return least
        high = low * (1.0 + _STEP)
        for t in _columns(_COLUMNS):
            pause()
            level = _lowest_failure(machine, oscillator, False, t, Interval(low, high), level, stack)
        low = high
    return min(level, least)
