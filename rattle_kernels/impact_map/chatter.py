"""Capture by ever lower bounces: permanent contact of the impacting model, and the way into it of the stiff one.

A ball bounces low on ground whose acceleration a(t) varies slowly. The action of its bounce, the area that it encloses
in the plane of depth and velocity, is then nearly constant. For a bounce that leaves the wall at speed v, with s = a/w
and w^2 = 2 kappa, it is

    J = 2 v^3/(3 a) + [(v^2 + s^2) (pi/2 + atan(s/v)) + s v]/w.

The first term is the flight's, the second the contact's, which the impacting model lacks. Damping lets J decay like
e^{-delta t}. What the slow change of a adds is of higher order in the duration of a bounce. So once bounces are short
damping wins, and J falls until no contact is left. In the impacting model v tends to zero. In the other model J falls
below that of contact at rest which just touches the wall, and the wall is never left again. Such a motion never rattles
again.

The bound is not guessed. The region ``J < bound`` is safe when P lowers J at every departure in it, for then it is
never left. The *descent* q = (change of ln J)/(delta T), T the duration of the bounce, is -1 in the limit of short
bounces. `descent_bound` computes q with P itself on a mesh over the region, and shrinks the region by steps of 0.8
until q <= -1/2 at all nodes and neighbouring nodes differ by less than 1/4. Then q stays below -1/4 in between. A
contact with -beta shows as a jump of q and fails the test.

With the *level* ``1.5 a J``, which is v^3 in the impacting model, no division is needed.
"""

import math

from rattle_kernels.impact_map.apply import next_impact
from rattle_kernels.model.flight import acceleration_range, rest_acceleration
from rattle_kernels.model.grazing_curve import LEAVING, grazing_flight
from rattle_kernels.model.outcome import OUTCOME_PERMANENT_CONTACT, OUTCOME_RETURNED
from rattle_kernels.numerics.jit import chosen_by_field, inlined, kernel

_PHASES = 96
_SPEEDS = 12
# The descent required at every node of a mesh, and by how much neighbouring nodes may differ.
REQUIRED_DESCENT = -0.5
_LARGEST_DIFFERENCE = 0.25
_SHRINK = 0.8
_ROUNDS = 200
_BISECTIONS = 50


@inlined
def ringing_radian(oscillator):
    """Time of one radian of the ringing in contact, 1/w; 0 in the impacting model."""
    return 1.0 / math.sqrt(2.0 * oscillator.stiffness)


@inlined
def level_bound(radian, acceleration, v):
    """Upper bound on the level ``1.5 a J`` of a departure, exact in the impacting model; cheap at every bounce."""
    rest = acceleration * radian
    return v * v * v + 1.5 * rest * (math.pi * (v * v + rest * rest) + rest * v)


@inlined
def bounce_level(radian, acceleration, v):
    """The level ``1.5 a J`` of a departure."""
    rest = acceleration * radian
    swing = (v * v + rest * rest) * (0.5 * math.pi + math.atan2(rest, v))
    return v * v * v + 1.5 * rest * (swing + rest * v)


@inlined
def is_below(bound, radian, acceleration, v):
    """Whether a departure lies in the region ``1.5 J < bound``, given the acceleration at rest there.

    Lanes ask this after every flight. It is the definition of captured.
    """
    return level_bound(radian, acceleration, v) < bound * acceleration


@inlined
def _is_never_captured(oscillator, bound, t, v):
    return False


@chosen_by_field("arcs", _is_never_captured)
def is_captured(oscillator, bound, t, v):
    """Whether ever lower bounces have captured the motion of a departure: it lies in the safe region.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    bound : float
        `capture_bound` of the oscillator.
    t, v : float
        Phase and speed of the departure.

    Returns
    -------
    bool
        Never beyond the bound of Eq. (8), where J is no measure of a bounce.
    """
    return is_below(bound, ringing_radian(oscillator), rest_acceleration(oscillator, t), v)


@inlined
def descent(oscillator, t, v):
    """Change of ln J under P, in units of delta T; -1 in the limit of short bounces or where contact is permanent.

    NaN where P fails.
    """
    impact = next_impact(oscillator, t, v)
    if impact.outcome == OUTCOME_PERMANENT_CONTACT:
        return -1.0
    if impact.outcome != OUTCOME_RETURNED:
        return math.nan
    radian = ringing_radian(oscillator)
    before, after = rest_acceleration(oscillator, t), rest_acceleration(oscillator, impact.t)
    growth = bounce_level(radian, after, impact.v) / bounce_level(radian, before, v) * before / after
    return math.log(growth) / (oscillator.damping * impact.duration)


@inlined
def fastest_below(oscillator, bound, t):
    """Fastest departure of the region ``1.5 J < bound`` at this phase, 0 where there is none."""
    radian, acceleration = ringing_radian(oscillator), rest_acceleration(oscillator, t)
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
def _descends(descent, inner, beside):
    """Whether the descent at a node suffices and differs little from that at two neighbours; not where it is NaN."""
    even = abs(descent - inner) < _LARGEST_DIFFERENCE and abs(descent - beside) < _LARGEST_DIFFERENCE
    return even and descent <= REQUIRED_DESCENT


@kernel
def descends_everywhere(mesh):
    """Whether the descent passes the test at every node of a mesh around a point where it is -1.

    Parameters
    ----------
    mesh : ndarray of float64, shape (sizes, phases)
        The descent, from the smallest size outwards; the last phase is next to the first.

    Returns
    -------
    bool
    """
    sizes, phases = mesh.shape
    for i in range(sizes):
        for j in range(phases):
            inner = mesh[i - 1, j] if i > 0 else -1.0
            if not _descends(mesh[i, j], inner, mesh[i, (j + 1) % phases]):
                return False
    return True


@inlined
def _is_safe(oscillator, bound, previous_row, row):
    """Test as `descends_everywhere`, phase by phase, up to the first node that fails."""
    for i in range(_PHASES + 1):
        phase = (i % _PHASES) / _PHASES
        edge = fastest_below(oscillator, bound, phase)
        for j in range(_SPEEDS):
            row[j] = descent(oscillator, phase, edge * (j + 1) / _SPEEDS) if edge > 0.0 else -1.0
            if not _descends(row[j], row[j - 1] if j > 0 else -1.0, previous_row[j] if i > 0 else row[j]):
                return False
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
        if bound * greatest <= bounce_level(ringing_radian(oscillator), greatest, 0.0):
            return 0.0
        if _is_safe(oscillator, bound, previous_row, row):
            return bound
        bound *= _SHRINK
    return 0.0
