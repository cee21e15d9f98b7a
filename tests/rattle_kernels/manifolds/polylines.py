"""How far points are from a curve that is drawn as pieces."""

import numpy as np


def distance_to(pieces, t, v, scale):
    """Distance of points from the polylines on the cylinder."""
    chords = [np.column_stack([p.t[:-1], p.v[:-1] / scale, p.t[1:], p.v[1:] / scale]) for p in pieces]
    a_t, a_v, b_t, b_v = np.concatenate(chords).T
    along_t, along_v = b_t - a_t, b_v - a_v
    to_t = np.subtract.outer(t, a_t)
    to_t -= np.rint(to_t - 0.5 * along_t)
    to_v = np.subtract.outer(v / scale, a_v)
    square = np.maximum(along_t**2 + along_v**2, 1e-300)
    part = np.clip((to_t * along_t + to_v * along_v) / square, 0.0, 1.0)
    return np.hypot(to_t - part * along_t, to_v - part * along_v).min(axis=1)
