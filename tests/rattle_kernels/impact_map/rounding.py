"""What rounding may do: half an ulp of phase and of speed at every impact, carried on by the map's derivative."""

import numpy as np


def _derivatives(oscillator, t, v, elapsed):
    """DP of every impact of a path that only falls back to +beta; columns by t and by v.

    A variation obeys eta'' + delta eta' = 0, and meets the wall later by -eta/Phi'.
    """
    damping, angle, durations = oscillator.damping, 2.0 * np.pi * t, np.diff(elapsed)
    forcing = 2.0 * np.pi * oscillator.eccentricity * (2.0 * np.pi * np.cos(angle) + damping * np.sin(angle))
    at_rest = 4.0 * np.pi * damping - forcing
    leaving, arriving = (at_rest + damping * v)[:-1], (at_rest - damping * v)[1:]
    stretch, decay = -np.expm1(-damping * durations) / damping, np.exp(-damping * durations)
    later = np.array([stretch * leaving - v[:-1], stretch]) / v[1:]
    faster = arriving * later - decay * np.array([leaving, np.ones_like(decay)])
    return np.stack([later, faster]).transpose(2, 0, 1)


def energy_rounding(oscillator, path, checkpoints):
    """Relative error of v^2 at some departures of a path if all impacts before round to the worst by half an ulp.

    `path` holds departures, the start first: phase, speed, forcing periods since the start.
    """
    t, v, elapsed = np.array(path, np.float64).T
    derivatives = _derivatives(oscillator, t, v, elapsed)
    half_ulps = np.spacing([t, v]).T / 2.0
    rows, bounds = np.zeros((len(checkpoints), 2)), np.zeros(len(checkpoints))
    for impact in range(max(checkpoints), 0, -1):
        rows[np.equal(checkpoints, impact)] = 0.0, 2.0 / v[impact]
        bounds += np.abs(rows) @ half_ulps[impact]
        rows = rows @ derivatives[impact - 1]
    return bounds
