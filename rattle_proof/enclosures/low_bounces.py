"""Low bounces lose their action: the change of v^3/a(t) under P, over all bounces of a box, down to none.

A bounce is given by its departure time t and its duration tau instead of its speed, for then nothing has to be solved.
With phi_k of x = delta tau and the derivatives a, a', a'', ... of the acceleration at rest at t, Taylor's theorem under
the integrals of the motion gives, exactly, with the last derivative taken somewhere in the bounce,

    v phi_1 = tau V,  V = a phi_2 + a' tau phi_3 + a'' tau^2 phi_4 + ...
    v' + v e^-x = tau (a phi_1 + a' tau phi_2 + a'' tau^2 phi_3 + ...).

Then v'/v = 1 + tau G and a(t + tau)/a = 1 + tau H with

    V G = a delta (2 phi_3 - phi_2) + a' B_1 + a'' tau B_2 + ...,   B_k = phi_1 phi_(k+1) - (2 - x phi_1) phi_(k+2),
    a H = a' + a'' tau/2 + a''' tau^2/6 + ....

The action v^3/a is multiplied by ``1 + tau S/(1 + tau H)``, ``S = 3 G - H + 3 tau G^2 + tau^2 G^3``. In 3 G - H the
powers of tau^0 but for the damping cancel, which is done by hand: ``3 B_1 - phi_2 = x (6 phi_4 - 2 phi_3 - 3 phi_2^2 +
3 phi_1 phi_3)``. So S tends to -delta as tau tends to 0, and a box that reaches down to tau = 0 is like any other.
"""

import math
from typing import NamedTuple

from rattle_kernels.numerics.jit import inlined_as_written
from rattle_proof.enclosures.enclosed_functions import phi, wave
from rattle_proof.enclosures.interval import Interval, add, divide, multiply, point, scale, square, subtract, up
from rattle_proof.enclosures.machine import FOUR_PI

ORDER = 10
"""Derivative of a in which the rest of Taylor's series is taken."""
_FACTORIALS = tuple(float(math.factorial(k)) for k in range(ORDER + 1))


class LowBounces(NamedTuple):
    """Bounces of a box: S, the other test of `low_bounces`, the speeds of departure and the actions v^3/a."""

    growth: Interval
    gain: Interval
    speed: Interval
    action: Interval


@inlined_as_written
def _derivative(machine, k, t):
    """The k-th derivative of a at all times of t."""
    total = Interval(0.0, 0.0)
    if k == 0:
        total = multiply(FOUR_PI, machine.damping)
    for n in range(machine.harmonics.shape[0]):
        order = machine.harmonics[n, 0]
        amplitude = Interval(machine.harmonics[n, 1], machine.harmonics[n, 2])
        phase = Interval(machine.harmonics[n, 3], machine.harmonics[n, 4])
        angle = wave(add(scale(t, order), phase))
        rate = scale(FOUR_PI, 0.5 * order)
        # -w^2 cos - delta w sin, turned by k quarters.
        cosine, sine = angle.cosine, angle.sine
        for _ in range(k % 4):
            cosine, sine = scale(sine, -1.0), cosine
        pushed = add(multiply(rate, cosine), multiply(machine.damping, sine))
        size = scale(multiply(amplitude, rate), -1.0)
        for _ in range(k):
            size = multiply(size, rate)
        total = add(total, multiply(size, pushed))
    return total


@inlined_as_written
def _power_sum(bends, tau, first, shift, beginning):
    """Sum over k from `first` of a^(k) tau^(k - beginning) phi_(k + shift), by Horner's rule; and with 1/k! for phi."""
    total = multiply(bends[ORDER], shift[ORDER])
    for k in range(ORDER - 1, first - 1, -1):
        total = add(multiply(total, tau), multiply(bends[k], shift[k]))
    for _ in range(first - beginning):
        total = multiply(total, tau)
    return total


@inlined_as_written
def low_bounces(machine, t, tau):
    """Change of the action over all bounces that leave at a time of t and last a time of tau.

    Parameters
    ----------
    machine : Machine
    t, tau : Interval
        ``0 <= delta tau <= 1``.

    Returns
    -------
    LowBounces
        The action is multiplied by ``1 + tau growth/(1 + tau H)`` and by r^3. It falls if ``growth < 0``, and also if
        ``gain = r^3 (1 + tau G)^3 - (1 + tau H) < 0``.
    """
    fallen = multiply(machine.damping, tau)
    x = Interval(max(fallen.low, 0.0), fallen.high)
    phis = [phi(k, x) for k in range(ORDER + 3)]
    during = Interval(t.low, add(t, tau).high)
    bends = [_derivative(machine, k, during if k == ORDER else t) for k in range(ORDER + 1)]
    a, jerk = bends[0], bends[1]
    twice = subtract(point(2.0), multiply(x, phis[1]))
    factors = [subtract(multiply(phis[1], phis[k + 1]), multiply(twice, phis[k + 2])) for k in range(ORDER + 1)]
    # The two parts of the rest are taken at different times: they need not cancel.
    parts = up(multiply(phis[1], phis[ORDER + 1]).high + multiply(twice, phis[ORDER + 2]).high)
    factors[ORDER] = Interval(-parts, parts)
    falls = [phis[k + 2] for k in range(ORDER + 1)]
    powers = [divide(point(1.0), point(_FACTORIALS[k])) for k in range(ORDER + 1)]
    fall = _power_sum(bends, tau, 0, falls, 0)
    damped = multiply(machine.damping, subtract(scale(phis[3], 2.0), phis[2]))
    speeding = add(multiply(a, damped), _power_sum(bends, tau, 1, factors, 1))
    g = divide(speeding, fall)
    # 3 G - H over a V.
    canceled = subtract(scale(phis[4], 6.0), scale(phis[3], 2.0))
    canceled = add(canceled, scale(subtract(multiply(phis[1], phis[3]), square(phis[2])), 3.0))
    leading = multiply(a, add(scale(multiply(a, damped), 3.0), multiply(jerk, multiply(x, canceled))))
    rest = scale(multiply(a, _power_sum(bends, tau, 2, factors, 1)), 3.0)
    rest = subtract(rest, multiply(jerk, _power_sum(bends, tau, 1, falls, 0)))
    rest = subtract(rest, multiply(fall, _power_sum(bends, tau, 2, powers, 1)))
    difference = divide(add(leading, rest), multiply(a, fall))
    squares = multiply(multiply(tau, square(g)), add(point(3.0), multiply(tau, g)))
    h = divide(_power_sum(bends, tau, 1, powers, 1), a)
    after = add(point(1.0), multiply(tau, g))
    cube = multiply(square(after), after)
    kept = multiply(square(machine.restitution), machine.restitution)
    gain = subtract(multiply(kept, cube), add(point(1.0), multiply(tau, h)))
    speed = divide(multiply(tau, fall), phis[1])
    return LowBounces(add(difference, squares), gain, speed, divide(multiply(square(speed), speed), a))
