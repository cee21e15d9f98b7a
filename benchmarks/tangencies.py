"""Whether chaos of Fig. 9 may have cones, by numbers: ``python -m benchmarks.tangencies [DAMPING ...]``.

A field of cones that DP keeps and stretches holds the direction that motions stretch from their past, and never the one
that their future shrinks. A million impacts of one motion are followed, the stretched direction forwards and the
shrunk one backwards. Printed are the angles between them, in units in which the motion is as wide as it is high; the
largest loss of a stretched vector; and what part of the returns from one departure that meets -beta to the next shrinks
it (docs/theory/proof.md, "Robust chaos").
"""

import sys
from typing import NamedTuple

import numpy as np
from numba import njit

from rattle_kernels import Oscillator, grazing_velocity, next_impacts
from rattle_kernels.impact_map.jacobian import next_impact_with_jacobian

DAMPINGS = (0.6, 0.625, 0.675)
IMPACTS = 1_000_000
# Impacts at either end whose directions have not settled; and of a motion that is tried.
_SETTLING, _TRIED = 100, 2000


class Followed(NamedTuple):
    """A motion's departures, the direction that its past stretches with its growth, and the one its future shrinks."""

    t: np.ndarray
    v: np.ndarray
    stretched: np.ndarray
    growth: np.ndarray
    shrunk: np.ndarray


@njit
def _follow(oscillator, t, v, times, speeds, stretched, growth, shrunk, slopes):
    along, across = 0.3, 0.5
    for i in range(times.size):
        landed, slope = next_impact_with_jacobian(oscillator, t, v)
        times[i], speeds[i], stretched[0, i], stretched[1, i] = t, v, along, across
        slopes[i, 0], slopes[i, 1], slopes[i, 2], slopes[i, 3] = slope.tt, slope.tv, slope.vt, slope.vv
        a, b = slope.tt * along + slope.tv * across, slope.vt * along + slope.vv * across
        length = np.hypot(a, b)
        along, across, growth[i] = a / length, b / length, np.log(length)
        t, v = landed.t % 1.0, landed.v
    along, across = 0.3, -0.5
    for i in range(times.size - 1, -1, -1):
        tt, tv, vt, vv = slopes[i]
        # The inverse of DP, but for its determinant: a length does not matter.
        a, b = vv * along - tv * across, tt * across - vt * along
        length = np.hypot(a, b)
        along, across = a / length, b / length
        shrunk[0, i], shrunk[1, i] = along, across


def follow(oscillator, t, v, impacts):
    """A motion with both directions."""
    times, speeds, growth = (np.empty(impacts) for _ in range(3))
    stretched, shrunk, slopes = np.empty((2, impacts)), np.empty((2, impacts)), np.empty((impacts, 4))
    _follow(oscillator, t, v, times, speeds, stretched, growth, shrunk, slopes)
    inner = slice(_SETTLING, -_SETTLING)
    return Followed(times[inner], speeds[inner], stretched[:, inner], growth[inner], shrunk[:, inner])


def chaotic_departure(oscillator):
    """A departure whose neighbours part, after random ones have settled."""
    random = np.random.default_rng(0)
    landed = next_impacts(oscillator, random.random(200), 6.0 * random.random(200) + 0.1, 3000, shortcuts=True)
    for n in np.flatnonzero(np.isfinite(landed.t) & (landed.v > 1.0)):
        t, v = float(landed.t[n] % 1.0), float(landed.v[n])
        if follow(oscillator, t, v, _TRIED).growth.mean() > 0.1:
            return t, v
    return None


def main(arguments):
    for damping in map(float, arguments) if arguments else DAMPINGS:
        oscillator = Oscillator(damping, 0.1, 0.6)
        start = chaotic_departure(oscillator)
        if start is None:
            print(f"damping {damping}: no chaotic motion was found")
            continue
        motion = follow(oscillator, *start, IMPACTS)
        unit = np.array([[np.ptp(motion.v) / np.ptp(motion.t)], [1.0]])
        one, other = unit * motion.stretched, unit * motion.shrunk
        lengths = np.linalg.norm(one, axis=0)
        sine = np.abs(one[0] * other[1] - one[1] * other[0]) / (lengths * np.linalg.norm(other, axis=0))
        angle = np.degrees(np.arcsin(np.minimum(sine, 1.0)))
        # In these units: the logarithm of a stretched vector's length, summed up.
        size = np.concatenate([[0.0], np.cumsum(motion.growth[:-1] + np.diff(np.log(lengths)))])
        loss = np.maximum.accumulate(size) - size
        last = int(loss.argmax())
        first = int(size[: last + 1].argmax())
        below = ", ".join(f"{100.0 * np.mean(angle < limit):.4f} % below {limit}" for limit in (1.0, 0.1, 0.01))
        returns = np.diff(size[np.flatnonzero(motion.v > grazing_velocity(oscillator, motion.t))])
        print(
            f"damping {damping}: exponent {motion.growth.mean():.4f}; angles in degrees: {below}, least "
            f"{angle.min():.2g}; largest loss e^-{loss[last]:.1f} in {last - first} impacts from t = "
            f"{motion.t[first]:.3f}, v = {motion.v[first]:.3f}; {100.0 * np.mean(returns < 0.0):.0f} % of the returns "
            f"shrink, the worst to one part in {np.exp(-returns.min()):.0f}",
            flush=True,
        )


if __name__ == "__main__":
    main(sys.argv[1:])
