"""Capture by ever lower bounces: permanent contact of the impacting model, and the way into it of the stiff one.

A ball that bounces low on ground whose acceleration a(t) varies slowly keeps the action of its bounce nearly constant,
the area that it encloses in the plane of depth and velocity. Of a bounce that leaves the wall at speed v, with s = a/w
and w^2 = 2 kappa,

    J = 2 v^3/(3 a) + [(v^2 + s^2) (pi/2 + atan(s/v)) + s v]/w,

the flight's part and the stay's, which is absent in the impacting model. Damping lets J decay like e^{-delta t}; what
the slow change of a adds is of higher order in the duration of a bounce. So once bounces are short damping wins: J
falls until no contact is left (impacting model: v tends to zero; else J falls below what contact at rest swings through
when it just touches the wall, and the wall is never left again). Such a motion never rattles again.

The bound is not guessed. The region ``J < bound`` is safe when P lowers J at every departure in it, for then it is
never left. The *descent* q = (change of ln J)/(delta T), T the duration of the bounce, is -1 in the limit of short
bounces. `descent_bound` computes q with P itself on a mesh over the region and takes the largest bound, by steps of
0.8, at which q <= -1/2 at all nodes while neighbouring nodes differ by less than 1/4: q stays below -1/4 in between. A
-beta contact shows as a jump of q and fails the test.

With the *level* ``1.5 a J``, which is v^3 in the impacting model, no division is needed.
"""

import math

from rattle_kernels.impact_map.apply import PERMANENT_CONTACT, RETURNED, next_impact
from rattle_kernels.model.flight import acceleration_range, rest_acceleration
from rattle_kernels.model.grazing_curve import LEAVING, grazing_flight
from rattle_kernels.numerics.jit import inlined, kernel

_PHASES = 96
_SPEEDS = 12
REQUIRED_DESCENT = -0.5
LARGEST_DIFFERENCE = 0.25
_SHRINK = 0.8
_ROUNDS = 200
_BISECTIONS = 50


@inlined
def stay_time(oscillator):
    """Radian of the ringing in contact, 1/w; 0 in the impacting model."""
    return 1.0 / math.sqrt(2.0 * oscillator.stiffness)


@inlined
def level_bound(radian, acceleration, v):
    """At least the level ``1.5 a J`` of a departure, just that in the impacting model; cheap at every bounce."""
    rest = acceleration * radian
    return v * v * v + 1.5 * rest * (math.pi * (v * v + rest * rest) + rest * v)


@inlined
def bounce_level(radian, acceleration, v):
    """The level ``1.5 a J`` of a departure."""
    rest = acceleration * radian
    swing = (v * v + rest * rest) * (0.5 * math.pi + math.atan2(rest, v))
    return v * v * v + 1.5 * rest * (swing + rest * v)


@inlined
def is_captured(oscillator, bound, t, v):
    """Whether the departure (t, v) is known to lie in the safe region of `descent_bound`."""
    acceleration = rest_acceleration(oscillator, t)
    return level_bound(stay_time(oscillator), acceleration, v) < bound * acceleration


@inlined
def descent(oscillator, t, v):
    """Change of ln J under P, in units of delta T; -1 in the limit of short bounces or where contact is permanent.

    NaN where P fails.
    """
    impact = next_impact(oscillator, t, v)
    if impact.outcome == PERMANENT_CONTACT:
        return -1.0
    if impact.outcome != RETURNED:
        return math.nan
    radian = stay_time(oscillator)
    before, after = rest_acceleration(oscillator, t), rest_acceleration(oscillator, impact.t)
    growth = bounce_level(radian, after, impact.v) / bounce_level(radian, before, v) * before / after
    return math.log(growth) / (oscillator.damping * impact.duration)


@inlined
def fastest_below(oscillator, bound, t):
    """Fastest departure of the region ``1.5 J < bound`` at this phase, 0 where there is none."""
    radian, acceleration = stay_time(oscillator), rest_acceleration(oscillator, t)
    high = (bound * acceleration) ** (1.0 / 3.0)
    if radian == 0.0:
        return high
    low = 0.0
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if bounce_level(radian, acceleration, middle) < bound * acceleration:
            low = middle
        else:
            high = middle
    return low


@inlined
def _is_safe(oscillator, bound, previous_row, row):
    for i in range(_PHASES + 1):
        phase = (i % _PHASES) / _PHASES
        edge = fastest_below(oscillator, bound, phase)
        below = -1.0
        for j in range(_SPEEDS):
            row[j] = descent(oscillator, phase, edge * (j + 1) / _SPEEDS) if edge > 0.0 else -1.0
            steep = abs(row[j] - below) >= LARGEST_DIFFERENCE
            steep = steep or (i > 0 and abs(row[j] - previous_row[j]) >= LARGEST_DIFFERENCE)
            if steep or not row[j] <= REQUIRED_DESCENT:
                return False
            below = row[j]
        previous_row[:] = row
    return True


@kernel
def descent_bound(oscillator, previous_row, row):
    """Largest bound on ``1.5 J`` found safe; 0 (nothing is ever captured) where none of the steps tried is.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    previous_row, row : ndarray of float64, shape (12,)
        Work space.

    Returns
    -------
    float
    """
    speed, _, _ = grazing_flight(oscillator, 0.0, LEAVING)
    bound = speed * speed * speed / rest_acceleration(oscillator, 0.0)
    _, greatest = acceleration_range(oscillator)
    for _ in range(_ROUNDS):
        # Below this some phases have no departure in the region: contact is soft, and nothing about a bounce is slow.
        if bound * greatest <= bounce_level(stay_time(oscillator), greatest, 0.0):
            return 0.0
        if _is_safe(oscillator, bound, previous_row, row):
            return bound
        bound *= _SHRINK
    return 0.0
