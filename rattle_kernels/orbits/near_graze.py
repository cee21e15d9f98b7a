"""Newton's method for orbits with a departure just above the grazing curve, in the root of its height.

Beyond v*(t) P is a smooth function of t and of s, the root of v - v*(t), through s = 0, where its derivative by v is
infinite. So Newton's method on P^p - x takes long steps in (t, s) where in (t, v) it only takes short ones. With S =
(1 - e^{-delta sigma})/delta, sigma the time from departure to touch, and a the acceleration at the departure, the curve
has the slope ``dv*/dt = v*/S - a``: the flights along it all touch, with velocity 0.
"""

import math

import numpy as np

from rattle_kernels.model.flight import fall_speed, rest_acceleration
from rattle_kernels.model.grazing_curve import LEAVING, grazing_flight
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import inlined, kernel
from rattle_kernels.numerics.pausing import Pause
from rattle_kernels.numerics.phase import part_turn, wrap
from rattle_kernels.orbits.periodic_orbit import iterate

# Close enough for Newton's method in (t, v) to go on.
_NEAR, _CLOSE = 1e-3, 1e-9
# Impacts of a round between two pauses: milliseconds in all rounds, but in the softest contacts a second.
_IMPACTS_A_LEG = 32


@inlined
def _curve(oscillator, t):
    """v*(t) and its slope."""
    speed, sigma, _ = grazing_flight(oscillator, t, LEAVING)
    stretch = -math.expm1(-oscillator.damping * sigma) / oscillator.damping
    return speed, speed / stretch - rest_acceleration(oscillator, t) - oscillator.damping * speed


@kernel
def _approach(oscillator, t, s, period, scale, rounds, near):
    """Newton's method in (t, s) from all departures; the roots `s` become speeds."""
    for i in range(t.size):
        here, root, residual = t[i], s[i], math.inf
        for _ in range(rounds):
            touching, slope = _curve(oscillator, here)
            speed = touching + root * root
            t1, v1, jacobian, _, _ = iterate(oscillator, here, speed, period[i])
            f, g = part_turn(t1 - here), v1 - speed
            residual = math.hypot(f, g / scale)
            if not residual > _CLOSE:
                break
            a, c = jacobian.tt - 1.0 + jacobian.tv * slope, jacobian.vt + (jacobian.vv - 1.0) * slope
            b, d = 2.0 * root * jacobian.tv, 2.0 * root * (jacobian.vv - 1.0)
            determinant = a * d - b * c
            dt, ds = (b * g - d * f) / determinant, (c * f - a * g) / determinant
            if not (abs(dt) <= 1.0 and math.isfinite(ds)):
                residual = math.inf
                break
            while root + ds <= 0.0:
                dt, ds = 0.5 * dt, 0.5 * ds
            here, root = wrap(here + dt), root + ds
        touching, _ = _curve(oscillator, here)
        t[i], s[i], near[i] = here, touching + root * root, residual < _NEAR


def approach_above(
    oscillator: Oscillator, t: np.ndarray, roots: np.ndarray, longest: int, rounds: int, pause: Pause
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Departures close to orbits, from departures above the grazing curve.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, roots : ndarray of float64, shape (n,)
        Phases, and roots of the heights v - v*(t).
    longest : int
        Impact periods 1 to this are tried from each.
    rounds : int
        Rounds of Newton's method.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    (ndarray, ndarray, ndarray)
        Phases, speeds and periods of those that have come close.
    """
    times, values = np.repeat(t, longest), np.repeat(roots, longest)
    period, near = np.tile(np.arange(1, longest + 1), t.size), np.zeros(times.size, np.bool_)
    scale, size = float(fall_speed(oscillator)), max(1, _IMPACTS_A_LEG // longest)
    for first in range(0, times.size, size):
        pause()
        leg = slice(first, first + size)
        _approach(oscillator, times[leg], values[leg], period[leg], scale, rounds, near[leg])
    return times[near], values[near], period[near]
