"""P(1,1,1) of finite stiffness with the times of its four pieces as unknowns, apart from any impact map.

The pieces are: fall, contact below, rise, contact above. With the departure (t, v) and the damping, that are seven
unknowns for six equations: each piece ends on its wall, and the motion closes. Where the contact below lasts d, the
solutions are followed as d grows from nearly nothing: d = 0 is the graze. A small change of a solution stays one
(multiplier +1) or becomes its own negative (-1) where the matrix of the equations, closed with that sign, is singular.
Derivatives are exact by complex steps. The short contact below cancels digits, so long floats are used.
"""

from typing import NamedTuple

import numpy as np

LONG = np.longdouble
PI = 2 * np.arctan2(LONG(1), LONG(0))
ECCENTRICITY, BETA = LONG(0.1), LONG(0.6)
TINY = LONG(1e-40)
FALL, BELOW, RISE, ABOVE, TIME, SPEED, DAMPING = range(7)


def forced(damping, t):
    """Displacement and rate of the forced part of a flight, Eq. (6)."""
    angle = 2.0 * PI * t
    rate = 4.0 * PI - 2.0 * PI * ECCENTRICITY * np.sin(angle)
    return 4.0 * PI * t + ECCENTRICITY * np.cos(angle), rate


def flight(damping, t, position, velocity, lasts):
    """Position and velocity after a flight."""
    here, rate = forced(damping, t)
    there, rate_there = forced(damping, t + lasts)
    own, left = velocity - rate, np.exp(-damping * lasts)
    return position + there - here + own * (1.0 - left) / damping, rate_there + own * left


def forced_in_contact(damping, stiffness, t):
    """Depth above a wall and its rate that the forcing keeps up in contact."""
    angle, square = 2.0 * PI * t, 2.0 * stiffness
    real, imaginary = -4.0 * PI**2 * ECCENTRICITY, 2.0 * PI * ECCENTRICITY * damping
    stiff, lag = square - 4.0 * PI**2, 2.0 * PI * damping
    size = stiff * stiff + lag * lag
    cosine, sine = (real * stiff + imaginary * lag) / size, (imaginary * stiff - real * lag) / size
    depth = 4.0 * PI * damping / square + cosine * np.cos(angle) - sine * np.sin(angle)
    return depth, -2.0 * PI * (cosine * np.sin(angle) + sine * np.cos(angle))


def contact(damping, stiffness, t, velocity, lasts):
    """Position above the wall and velocity after a contact that begins on the wall."""
    depth, rate = forced_in_contact(damping, stiffness, t)
    there, rate_there = forced_in_contact(damping, stiffness, t + lasts)
    frequency = np.sqrt(2.0 * stiffness - 0.25 * damping * damping)
    left, turn = np.exp(-0.5 * damping * lasts), frequency * lasts
    swing, wave = -depth, (velocity - rate - 0.5 * damping * depth) / frequency
    own = left * (swing * np.cos(turn) + wave * np.sin(turn))
    own_rate = left * frequency * (wave * np.cos(turn) - swing * np.sin(turn)) - 0.5 * damping * own
    return there + own, rate_there + own_rate


def equations(stiffness, x, sign=1.0):
    """Where each piece ends, and the departure after it less `sign` times the one before."""
    damping, t, velocity = x[DAMPING], x[TIME], -x[SPEED]
    ends = []
    position, velocity = flight(damping, t, BETA, velocity, x[FALL])
    ends.append(position + BETA)
    t = t + x[FALL]
    position, velocity = contact(damping, stiffness, t, velocity, x[BELOW])
    ends.append(position / x[BELOW])
    t = t + x[BELOW]
    position, velocity = flight(damping, t, -BETA, velocity, x[RISE])
    ends.append(position - BETA)
    t = t + x[RISE]
    position, velocity = contact(damping, stiffness, t, velocity, x[ABOVE])
    ends.append(position / x[ABOVE])
    return np.array([*ends, t + x[ABOVE] - sign * x[TIME] - 1.0, -velocity - sign * x[SPEED]])


def derivative(stiffness, x, sign=1.0):
    """Matrix of the equations by all seven unknowns."""
    columns = [equations(stiffness, x + 1j * TINY * axis, sign).imag / TINY for axis in np.eye(7, dtype=LONG)]
    return np.array(columns).T


def determinant(matrix):
    """Determinant by elimination in long floats, which `numpy.linalg` does not take."""
    rows, product = matrix.copy(), LONG(1)
    for k in range(len(rows)):
        pivot = k + int(np.argmax(np.abs(rows[k:, k])))
        if pivot != k:
            rows[[k, pivot]], product = rows[[pivot, k]], -product
        product *= rows[k, k]
        for i in range(k + 1, len(rows)):
            rows[i] -= rows[k] * (rows[i, k] / rows[k, k])
    return product


class Solution(NamedTuple):
    """A solution, and the determinants that vanish at multipliers +1 and -1."""

    x: np.ndarray
    fold: float
    doubling: float


def solve(stiffness, guess):
    """Newton's method at the guess's contact time below."""
    x = np.array(guess, dtype=LONG)
    free = [FALL, RISE, ABOVE, TIME, SPEED, DAMPING]
    for _ in range(30):
        residual = equations(stiffness, x.astype(np.clongdouble)).real
        change = np.linalg.solve(derivative(stiffness, x)[:, free].astype(float), -residual.astype(float))
        x[free] += change
        if np.abs(change).max() < 1e-15:
            break
    else:
        raise AssertionError("Newton's method does not converge")
    signs = (determinant(derivative(stiffness, x, sign)[:, :DAMPING]) for sign in (1.0, -1.0))
    return Solution(x, *signs)


def special_points(stiffness, guess, longest, factor=1.2):
    """Kinds and damping of special points of P(1,1,1) from its graze to a contact time below, in order."""
    lasts = 1e-5 / stiffness
    last = solve(stiffness, np.where(np.arange(7) == BELOW, lasts, guess))
    found = []
    while lasts < longest:
        lasts *= factor
        now = solve(stiffness, np.where(np.arange(7) == BELOW, lasts, last.x))
        for kind in ("fold", "doubling"):
            if getattr(last, kind) * getattr(now, kind) < 0.0:
                found.append((kind, bisected(stiffness, kind, last, now)))
        last = now
    return found


def bisected(stiffness, kind, low, high):
    """Damping where a determinant vanishes between two solutions."""
    for _ in range(45):
        middle = solve(stiffness, 0.5 * (low.x + high.x))
        if getattr(middle, kind) * getattr(low, kind) > 0.0:
            low = middle
        else:
            high = middle
    return float(middle.x[DAMPING])
