"""Curves of solutions of n equations in n + 1 unknowns, by pseudo-arclength (Keller, 1977).

From a point z with unit tangent s the next is predicted at z + h s and corrected by Newton's method in the plane
through it across s:

    F(y) = 0,    s . (y - z - h s) = 0.

The bordered matrix is regular where the curve merely turns (a fold), so turns are passed like any other point. The step
h grows where Newton's method is quick. It is halved where the method fails, where the tangent turns by more than 18
degrees, or where y is further from the prediction than such a turn allows: h tan 18. Otherwise Newton's method could
land on another curve. The caller may refuse a step for a reason of its own. When h falls below the least step the curve
stalls. A stall is a result: the caller finds out its cause.
"""

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

# F and its Jacobian, or None where they are not defined.
System = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray] | None]

_NEWTON_STEPS = 8
# Scaled equations that are off by no more than that are solved: several units in the last place of a phase.
_ROUNDED = 8.0 * np.finfo(float).eps
_QUICK = 4
# Neighbouring tangents that differ by more than 18 degrees need a shorter step.
LEAST_COSINE = 0.95
# A curve whose tangent turns by no more than that stays in a cone around it: so far from its axis at a distance of 1.
WIDEST = math.tan(math.acos(LEAST_COSINE))
_GROWTH = 1.5
# Steps of up to so many least ones may turn a corner.
CORNER = 4.0
# Beyond a corner steps grow again, by a half each. So many in a row below a hundred least ones, twice as many as that
# takes, follow the corrector's errors and not the curve.
_SHORT, _MOST_SHORT = 100.0, 24


class Steps(NamedTuple):
    """First, least and greatest step, in the units of the scaled unknowns.

    The least one is ten times the corrector's tolerance. Shorter steps would follow its errors.
    """

    first: float = 1e-3
    least: float = 1e-10
    most: float = 0.02


class Solution(NamedTuple):
    """Where Newton's method ended, the Jacobian before its last step, the number of steps, and the last one's size."""

    z: np.ndarray
    jacobian: np.ndarray
    steps: int
    last_step: float


class CurvePoint(NamedTuple):
    """A point, the unit tangent there, and the step that led to it."""

    z: np.ndarray
    tangent: np.ndarray
    step: float


# Whether a step from one point to another is accepted.
Accept = Callable[[CurvePoint, CurvePoint], bool]


def unit_tangent(jacobian: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Null vector of an n x (n + 1) Jacobian, of length 1, pointing along another vector.

    Parameters
    ----------
    jacobian : ndarray, shape (n, n + 1)
    along : ndarray, shape (n + 1,)

    Returns
    -------
    ndarray, shape (n + 1,)
    """
    null: np.ndarray = np.linalg.svd(jacobian / np.abs(jacobian).max(axis=1, keepdims=True))[2][-1]
    return null if null @ along >= 0.0 else -null


def solve(
    system: System, guess: np.ndarray, across: np.ndarray | None = None, tolerance: float = 1e-11
) -> Solution | None:
    """Newton's method for F = 0, within a plane through the guess where the system lacks an equation.

    Parameters
    ----------
    system : callable
        F and its Jacobian at a point, or None.
    guess : ndarray, shape (n,) or (n + 1,)
    across : ndarray, shape (n + 1,), optional
        Normal of that plane, needed where F has one component less than there are unknowns.
    tolerance : float
        Greatest last step, in scaled unknowns. Where F is off by rounding alone, a longer one follows its errors, and
        the method ends there, too: so do orbits of several touches at once, which rounding shifts by 1e-9.

    Returns
    -------
    Solution or None
        None where Newton's method failed.
    """
    z, last = guess, np.inf
    for steps in range(1, _NEWTON_STEPS + 1):
        evaluated = system(z)
        if evaluated is None:
            return None
        residual, jacobian = evaluated
        matrix = jacobian
        if across is not None:
            matrix, residual = np.vstack([jacobian, across]), np.append(residual, across @ (z - guess))
        try:
            change = np.linalg.solve(matrix, -residual)
        except np.linalg.LinAlgError:
            return None
        size = float(np.abs(change).max())
        if np.abs(residual).max() <= _ROUNDED and np.isfinite(size):
            return Solution(z, jacobian, steps, size)
        if not size < max(2.0 * last, 1e3 * tolerance):
            return None
        z, last = z + change, size
        if size <= tolerance:
            return Solution(z, jacobian, steps, size)
    return None


def _step(system: System, at: CurvePoint, step: float, corner: bool) -> tuple[CurvePoint, int] | None:
    """Next point of a curve and the number of Newton steps; None if it is not found or lies out of the cone."""
    predicted = at.z + step * at.tangent
    corrected = solve(system, predicted, at.tangent)
    if corrected is None:
        return None
    tangent = unit_tangent(corrected.jacobian, at.tangent)
    inside = np.linalg.norm(corrected.z - predicted) <= WIDEST * step and tangent @ at.tangent >= LEAST_COSINE
    return (CurvePoint(corrected.z, tangent, step), corrected.steps) if inside or corner else None


def follow_curve(
    system: System, start: np.ndarray, along: np.ndarray, steps: Steps, accept: Accept | None = None
) -> Iterator[CurvePoint]:
    """Follow the curve through `start` point by point until it stalls.

    Parameters
    ----------
    system : callable
        As for `solve`.
    start : ndarray, shape (n + 1,)
        A solution; it is not yielded.
    along : ndarray, shape (n + 1,)
        Direction: of the two ways along the curve, the one whose tangent points along this vector.
    steps : Steps
    accept : callable, optional
        Called with two neighbouring points. A step that it refuses is halved.

    Yields
    ------
    CurvePoint
        The iterator ends where no step longer than the least one succeeds, or only short ones do.
    """
    evaluated = system(start)
    if evaluated is None:
        return
    at, step, short = CurvePoint(start, unit_tangent(evaluated[1], along), 0.0), steps.first, 0
    while step >= steps.least and short < _MOST_SHORT:
        # A corner is passed by a step so short that nothing else is near.
        found = _step(system, at, step, corner=step <= CORNER * steps.least)
        if found is None or (accept is not None and not accept(at, found[0])):
            step *= 0.5
            continue
        at = found[0]
        short = short + 1 if step < _SHORT * steps.least else 0
        yield at
        if found[1] <= _QUICK:
            step = min(_GROWTH * step, steps.most)
