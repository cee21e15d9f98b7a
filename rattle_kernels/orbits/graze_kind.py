"""What a graze does to the orbit that touches -beta: whether it goes on with one impact more, folds, or becomes chaos.

Let x and x' be position above -beta and velocity at the phase of the touch, and N the derivative of one turn of the
orbit there, from touch to touch, in (x, x'), with the flight that touches passing -beta as if it were not there. If the
parameter moves the touch to a depth d below the wall, the flight meets it with speed ``u = sqrt(2 a d)``, a being the
acceleration there, and leaves with (1 + r) u more velocity than the flight that passes. That push is large beside d. A
turn later it has become a displacement ``N_12 (1 + r) u``, and it moves the fixed point by ``(I - N)^-1 N (0, (1 + r)
u)``. Its position is

    -d + c (1 + r) u = -u^2/(2 a),    c = N_12/det(I - N),

where the left side is that of the orbit that hits, seen as a flight that passes. So, where c > 0, the depth d at which
the orbit that passes would be is positive: the orbit that hits lies on the other side of the graze, and *the orbit
persists* with one impact more. Where c < 0, d is negative: both lie on the same side, where they meet and vanish in a
*nonsmooth fold*. Where N_12 = 0 the graze is of codimension two. N has the multipliers of the orbit, so det(I - N) is
positive unless exactly one of them exceeds 1 (Nordmark, J. Sound Vib. 145 (1991) 279; Fredriksson and Nordmark, Proc.
R. Soc. A 453 (1997) 1261).

The orbit that persists has a trace that grows without bound towards the graze, like 1/u. It is a saddle there. What
attracts instead is a matter of the powers of N. The n-th turn after an impact lies at ``(N^n)_12 (1 + r) u``. If all of
these are positive, as with real positive multipliers, the flight is thrown off the wall and comes back along the slower
direction: the motion stays small. If one is negative, the next impact is far deeper, and the motion leaves: its size
does not vanish with the distance from the graze. `attractor_beyond` follows the leading terms: N, and the push of an
impact with a constant acceleration. They stay bounded, since N contracts and the push is a square root.
"""

import math
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from rattle_kernels.model.flight import rest_acceleration
from rattle_kernels.model.grazing_curve import LEAVING, grazing_flight
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.phase import wrap
from rattle_kernels.orbits.bifurcation_point import SpecialPoint
from rattle_kernels.orbits.closure import OrbitShape, closure
from rattle_kernels.orbits.orbit_equations import SpecialKind, special_system, unknowns

# Turns of the leading terms before and while the exponent is taken.
_SETTLING, _BATCH, _BATCHES = 2_000, 10_000, 20


class GrazeScenario(StrEnum):
    """What becomes of the orbit that touches."""

    PERSISTS = "persists"
    FOLDS = "folds"


@kernel
def touch_after(oscillator, t):
    """Speed of the departure at t that touches -beta, the time to the touch, and the accelerations at both at rest.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller (Eq. 8 holds).
    t : float

    Returns
    -------
    (float, float, float, float)
    """
    speed, sigma, _ = grazing_flight(oscillator, t, LEAVING)
    return speed, sigma, rest_acceleration(oscillator, t), rest_acceleration(oscillator, t + sigma)


def touch_monodromy(oscillator: Oscillator, shape: OrbitShape, t: float, v: float) -> np.ndarray | None:
    """N, the derivative of a turn in position and velocity at the touch of the flight that leaves +beta at t.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller; up to the bound of Eq. (8).
    shape : OrbitShape
        With the bit of the first flight in ``over``.
    t, v : float
        Departure of the flight that touches.

    Returns
    -------
    ndarray, shape (2, 2), or None
        None where the turn does not come back.
    """
    closed = closure(oscillator, "damping", shape, t, v)
    if closed is None:
        return None
    _, sigma, leaving, _ = touch_after(oscillator, t)
    damping = oscillator.damping
    stretch, decay = -math.expm1(-damping * sigma) / damping, math.exp(-damping * sigma)
    # From (t, v) at departure, with x' = -v there, to (x, x') at one instant, and then along the flight.
    at_once = np.array([[v, 0.0], [-(leaving + damping * v), -1.0]])
    down = np.array([[1.0, stretch], [0.0, decay]]) @ at_once
    there: np.ndarray = down @ closed.jacobian @ np.linalg.inv(down)
    return there


def graze_response(turn: np.ndarray) -> float:
    """``c = N_12/det(I - N)``: where it is positive, the orbit persists with one impact more; else it folds.

    Parameters
    ----------
    turn : ndarray, shape (2, 2)
        N, as `touch_monodromy` finds it.

    Returns
    -------
    float
    """
    (a, b), (c, d) = turn.tolist()
    determinant: float = (1.0 - a) * (1.0 - d) - b * c
    return b / determinant if determinant else math.copysign(math.inf, b)


def small_attractor_follows(turn: np.ndarray) -> bool:
    """Whether a small attractor lies beyond a graze at once, where the orbit that misses attracts no more.

    Parameters
    ----------
    turn : ndarray, shape (2, 2)
        N, as `touch_monodromy` finds it.

    Returns
    -------
    bool
    """
    multipliers = np.linalg.eigvals(turn)
    slower, faster = sorted(multipliers.real)
    return bool(turn[0, 1] > 0.0 and not multipliers.imag.any() and 0.0 < slower < faster < 1.0)


class GrazeKind(NamedTuple):
    """What a graze does.

    Parameters
    ----------
    phase : float
        Of the touch, in [0, 1).
    acceleration : float
        At the touch, at rest: positive, away from -beta.
    monodromy : ndarray, shape (2, 2)
        N.
    response : float
        ``c = N_12/det(I - N)``, by which the fixed point rises for a push of 1. Its sign decides.
    rate : float
        By how much the lowest point of the orbit that passes rises above -beta as the parameter grows by 1.
    restitution : float
    """

    phase: float
    acceleration: float
    monodromy: np.ndarray
    response: float
    rate: float
    restitution: float

    @property
    def scenario(self) -> GrazeScenario:
        """Whether the orbit goes on with one impact more, or meets its twin and vanishes."""
        return GrazeScenario.PERSISTS if self.response > 0.0 else GrazeScenario.FOLDS

    @property
    def multipliers(self) -> np.ndarray:
        """Of the orbit that misses, shape (2,), complex."""
        return np.linalg.eigvals(self.monodromy).astype(complex)

    @property
    def attracts_beside(self) -> bool:
        """Whether a small attractor lies beyond the graze, where the orbit that misses attracts no more."""
        return small_attractor_follows(self.monodromy)

    @property
    def misses(self) -> int:
        """Side of the parameter on which the orbit misses -beta: +1 above the graze, -1 below it."""
        return 1 if self.rate > 0.0 else -1

    @property
    def hits(self) -> int:
        """Side of the parameter on which the orbit with one impact more exists, close to the graze."""
        return -self.misses if self.scenario == GrazeScenario.PERSISTS else self.misses


def graze_kind(point: SpecialPoint) -> GrazeKind | None:
    """Find out what a graze of -beta does.

    Parameters
    ----------
    point : SpecialPoint
        A graze, from `continue_orbit` or elsewhere.

    Returns
    -------
    GrazeKind or None
        None beyond the bound of Eq. (8), where no flight passes -beta as if it were not there, and where the turn
        does not come back.

    Raises
    ------
    ValueError
        If the point is no graze of -beta.
    """
    if point.kind != SpecialKind.GRAZING:
        raise ValueError(f"the point must be a graze of -beta, not a {point.kind}")
    oscillator = point.oscillator
    if oscillator.is_loose:
        return None
    shape = OrbitShape(point.forcing_periods, point.upper_contacts, 1)
    t, v = float(point.t[0]), float(point.v[0])
    turn = touch_monodromy(oscillator, shape, t, v)
    space = unknowns(oscillator, (point.parameter,))
    evaluated = special_system(SpecialKind.GRAZING, space, shape)(space.write(oscillator, t, v))
    if turn is None or evaluated is None:
        return None
    _, sigma, _, acceleration = touch_after(oscillator, t)
    # Along the orbits that pass, how their departure speed grows beyond that of the flight that touches.
    equations = evaluated[1]
    along = np.linalg.solve(equations[:2, :2], -equations[:2, 2])
    faster = float(equations[2] @ np.append(along, 1.0)) * space.scales[1] / space.scales[2]
    lower = -math.expm1(-oscillator.damping * sigma) / oscillator.damping
    return GrazeKind(
        float(wrap(t + sigma)), float(acceleration), turn, graze_response(turn), -lower * faster,
        oscillator.restitution,
    )  # fmt: skip


class AttractorBeyond(NamedTuple):
    """What the leading terms of the map attract to beyond a graze.

    Parameters
    ----------
    exponent : float
        Largest Lyapunov exponent per turn. Positive: chaos.
    exponent_error : float
        Its standard error: that of the mean of batches of turns.
    impacts : float
        Impacts with -beta per turn, of the flight that touches.
    size : float
        Greatest height above -beta that the touch reaches, in units of Phi.
    """

    exponent: float
    exponent_error: float
    impacts: float
    size: float


def attractor_beyond(graze: GrazeKind, distance: float) -> AttractorBeyond | None:
    """Follow the leading terms of the map beyond a graze, where the orbit that misses is gone.

    Parameters
    ----------
    graze : GrazeKind
        As `graze_kind` finds it.
    distance : float
        Of the parameter from the graze, on the side where the orbit would pass below -beta; its sign is not used.

    Returns
    -------
    AttractorBeyond or None
        A prediction of leading order: terms of the relative size of the square root of the depth are left out. None
        where nothing small attracts (`GrazeKind.attracts_beside`).
    """
    if not graze.attracts_beside:
        return None
    depth, a = float(abs(graze.rate * distance)), float(graze.acceleration)
    (xx, xv), (vx, vv) = graze.monodromy.tolist()
    x = v = 0.0
    along = (1.0, 0.0)
    grown, impacts, highest = np.zeros(_BATCHES), 0, 0.0
    for turn in range(-_SETTLING, _BATCH * _BATCHES):
        dx, dv = along
        # Height of the lowest point, where the flight passes -beta as if it were not there.
        lowest = x - depth - v * v / (2.0 * a)
        if lowest < 0.0:
            u = math.sqrt(-2.0 * a * lowest)
            du = (v * dv - a * dx) / u
            since, push = (u + v) / a, 1.0 + graze.restitution
            dx, dv = dx + push * (du * since + u * (du + dv) / a), dv + push * du
            x, v = x + push * u * since, v + push * u
        x, v = xx * x + xv * v, vx * x + vv * v
        dx, dv = xx * dx + xv * dv, vx * dx + vv * dv
        length = math.hypot(dx, dv)
        along = (dx / length, dv / length)
        if turn >= 0:
            grown[turn // _BATCH] += math.log(length) / _BATCH
            impacts += lowest < 0.0
            highest = max(highest, x - depth)
    error = float(grown.std(ddof=1)) / math.sqrt(_BATCHES)
    return AttractorBeyond(float(grown.mean()), error, impacts / (_BATCH * _BATCHES), highest)
