"""Complete chatter: bounces on one wall that accumulate before their arc ends. Then the gear rests until it ends.

Let a gear leave a wall at speed v, and let p(t) be the acceleration that presses it back: a on +beta, -a on -beta. With
L a bound on its rate of change, ``p >= p_- = p(t)/2`` holds for the time ``W = min(R, p(t)/(2 L))``, R what is left of
the arc, and ``p <= 3 p_-``. Within W a bounce that leaves with a speed of at most v

- rises for ``v/p_-`` at most and to ``v^2/(2 p_min)`` at most, p_min the least p on its way, for damping holds it, too;
- arrives with ``u <= v sqrt(p_max/p_min) <= sqrt(3) v``, for damping takes from what the fall gives;
- falls for ``2 v/p_-`` at most if ``sqrt(3) delta v <= 3/4 p_-``, for then it is accelerated by ``p_-/4`` at least.

So it takes ``T <= 3 v/p_-``, in which p changes by L T at most. After its impact the speed is

    r u <= q v,    q = r sqrt(1 + 3 L v/p_-^2).

If q < 1 the speeds fall geometrically, durations with them, and all bounces together take ``3 v/(p_- (1 - q))`` at
most. If that is within W, all of this holds to their end. The gear then lies on the wall and is pressed to it until the
arc ends. The other wall is not met if ``v^2/(2 p_-) < 2 beta``.

If this cannot be shown the bounces are followed one by one (`accumulates`). Either they come to where it can be shown,
or one of them lasts beyond the end of the arc or meets the other wall.

At Gamma = 1 the zero of a(t), where it does not change its sign, ends an arc, too. A gear that rests stays there.
Bounces that go on beyond the zero are bounces: they may never accumulate.
"""

import math
from typing import NamedTuple

from rattle_kernels.impact_map.arc_flights import next_loose_contact
from rattle_kernels.model.arcs import is_pressed, time_to_end
from rattle_kernels.model.flight import rest_acceleration
from rattle_kernels.numerics.jit import inlined
from rattle_kernels.numerics.phase import wrap

# Kept from the bounds, for rounding; of a(t) it is a part of its largest value.
_MARGIN = 1.0 - 1e-9
_ROUNDING = 1e-13
# Bounces on one arc that are followed. At r = 0.999 speeds fall by a factor of 1e43 within them.
_MOST_BOUNCES = 100_000


class Bounded(NamedTuple):
    """What bounces are bounded by; ``strongest`` and ``change`` are bounds on ``|a|`` and ``|a'|``."""

    damping: float
    two_beta: float
    restitution: float
    strongest: float
    change: float


@inlined
def comes_to_rest(oscillator, wall, phase, speed):
    """Whether a departure is sure to come to rest on the wall that it leaves, by bounces that end before the arc does.

    Parameters
    ----------
    oscillator : LooseOscillator
        Checked by the caller.
    wall : float
        UPPER or LOWER.
    phase, speed : float
        Of the departure; the phase in [0, 1).

    Returns
    -------
    bool
        Never where impacts are elastic.
    """
    arcs, two_beta = oscillator.arcs, 2.0 * oscillator.half_backlash
    bounded = Bounded(oscillator.damping, two_beta, oscillator.restitution, arcs.strongest, arcs.change)
    return is_sure_to_rest(bounded, wall * rest_acceleration(oscillator, phase), time_to_end(arcs, phase), speed)


@inlined
def is_sure_to_rest(bounded, pressing, left, speed):
    """As `comes_to_rest`, of a gear that is pressed to the wall by an acceleration, with some time left on the arc.

    ``bounded`` has the fields of `Bounded`.
    """
    restitution = bounded.restitution
    pressing -= _ROUNDING * bounded.strongest
    if not (pressing > 0.0 and restitution < 1.0):
        return False
    least = 0.5 * _MARGIN * pressing
    window = _MARGIN * min(left, 0.5 * pressing / bounded.change)
    shrink = restitution * math.sqrt(1.0 + 3.0 * bounded.change * speed / (least * least))
    low = math.sqrt(3.0) * bounded.damping * speed <= 0.75 * least
    below = speed * speed < 2.0 * _MARGIN * bounded.two_beta * least
    return low and below and shrink < _MARGIN and 3.0 * speed <= window * least * (1.0 - shrink)


@inlined
def accumulates(oscillator, wall, phase, speed):
    """Whether the bounces of a departure accumulate on the wall that it leaves before the arc ends: a complete chatter.

    Parameters
    ----------
    oscillator : LooseOscillator
        Checked by the caller.
    wall : float
        UPPER or LOWER.
    phase, speed : float
        Of the departure; the phase in [0, 1).

    Returns
    -------
    bool
        Never where impacts are elastic, or where the gear is not pressed to the wall.
    """
    if oscillator.restitution == 1.0 or not is_pressed(oscillator.arcs, wall, phase):
        return False
    left = time_to_end(oscillator.arcs, phase)
    for _ in range(_MOST_BOUNCES):
        if comes_to_rest(oscillator, wall, phase, speed):
            return True
        end = next_loose_contact(oscillator, wall, phase, -wall * speed)
        left -= end.duration
        if not (end.found and end.wall == wall and left > 0.0):
            return False
        phase, speed = wrap(end.phase), oscillator.restitution * abs(end.velocity)
    return False
