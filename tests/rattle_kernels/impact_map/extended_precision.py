"""The impacting map in 80-bit arithmetic: the kernels say which wall a flight meets, Newton's method where, here.

The flight is taken in its plainest form, ``4 pi tau + eps (cos - cos0) + B (e^{-delta tau} - 1)``, of which the
kernels' own shares nothing.
"""

import numpy as np

from rattle_kernels.impact_map.apply import LOWER, UPPER, next_contact

EXTENDED = np.longdouble
_PI = 4 * np.arctan(EXTENDED(1))
_NEWTON_STEPS = 3


def _land(oscillator, phase, velocity, target, guess):
    """End of a flight from a wall: duration and velocity."""
    damping, eccentricity = EXTENDED(oscillator.damping), EXTENDED(oscillator.eccentricity)
    drag = (4 * _PI - 2 * _PI * eccentricity * np.sin(2 * _PI * phase) - velocity) / damping
    tau = EXTENDED(guess)
    for step in range(_NEWTON_STEPS + 1):
        angle = 2 * _PI * (phase + tau)
        lost = np.expm1(-damping * tau)
        rate = 4 * _PI - 2 * _PI * eccentricity * np.sin(angle) - damping * drag * (lost + 1)
        if step == _NEWTON_STEPS:
            return tau, rate
        swing = eccentricity * (np.cos(angle) - np.cos(2 * _PI * phase))
        tau -= (4 * _PI * tau + swing + drag * lost - target) / rate


def run_extended(oscillator, t, v, impacts):
    """Departure after so many impacts, and the forcing periods that passed."""
    phase, speed, elapsed = EXTENDED(t), EXTENDED(v), EXTENDED(0)
    two_beta = 2 * EXTENDED(oscillator.half_backlash)
    for _ in range(impacts):
        wall, velocity = UPPER, -speed
        while True:
            contact = next_contact(oscillator, wall, float(phase), float(velocity), 1.0)
            target = EXTENDED(0) if contact.wall == wall else (two_beta if wall == LOWER else -two_beta)
            tau, arrival = _land(oscillator, phase, velocity, target, contact.duration)
            phase, elapsed, velocity, wall = (phase + tau) % 1, elapsed + tau, -arrival, contact.wall
            if wall == UPPER:
                break
        speed = -velocity
    return phase, speed, elapsed
