"""Special points of periodic orbits: where a branch turns, doubles, grazes or loses contact; each by its own equations.

*Saddle-node*: a multiplier is +1, trace DP^p = 1 + e^{-delta m}. *Period doubling*: a multiplier is -1, trace DP^p = -1
- e^{-delta m}. A Neimark-Sacker bifurcation is impossible, because the multipliers' product is e^{-delta m} < 1
(`periodic_orbit`).

*Grazing*: a flight of the orbit touches -beta with no speed, v = v*(t) at its departure. Seen from orbits that miss the
wall the departure's speed reaches v*; seen from orbits that meet it the speed there falls to zero like the square root
of v - v*, and DP grows without bound (impacting model). The touching flight itself belongs to both, so the equations
use one that passes -beta as if it were not there, and stay smooth.

*Contact loss* (finite stiffness): a stay beyond +beta touches Phi = +beta from inside at phase t, x = x' = 0, so that
beyond this point it splits in two, with one more departure of speed 0 between. The orbit is followed from rest on the
wall at t through its departures to its last stay, whose x and x' the time m after t are the two equations in (t, p).

All are solved by Newton's method on the closing equations and the special one together, in (t, v, p); what is not known
in closed form of the Jacobian, the gradient of the special equation, is taken by central differences: their error slows
the last step or two and does not enter the result.
"""

import math
from collections.abc import Callable
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.apply import FORWARDS, next_impact, walk
from rattle_kernels.impact_map.flights import UPPER
from rattle_kernels.model.contact import enter_contact, follow_contact, state_in_contact
from rattle_kernels.model.flight import fall_speed
from rattle_kernels.model.oscillator import (
    Oscillator,
    OutsideDomain,
    check_domain,
    eccentricity_bound_smooth_maxima,
)
from rattle_kernels.numerics.jit import inlined, kernel
from rattle_kernels.numerics.phase import wrap
from rattle_kernels.numerics.pseudo_arclength import System, solve
from rattle_kernels.orbits.closure import OrbitShape, closure, grazing_speed_at, orbit_from, stability_gap

# Central differences of quantities known to 1e-13 or so: truncation 1e-12, round-off 1e-7.
_DIFFERENCE = 1e-6
# The least steps of a curve end within this part of the bound of Eq. (8).
_EDGE = 1e-5
# Points of a stay at which its least depth is looked for, a guess to start from.
_SAMPLES = 400


class SpecialKind(StrEnum):
    """What happens at a special point."""

    SADDLE_NODE = "saddle-node"
    PERIOD_DOUBLING = "period doubling"
    GRAZING = "grazing"
    CONTACT_LOSS = "contact loss"


class SpecialPoint(NamedTuple):
    """A special point, located.

    ``oscillator`` has the parameter's value there. ``t``, ``v`` (shape (upper_contacts,)) are the orbit's departures;
    the first one is that which grazes, or the one of speed 0 at which contact is lost. ``multipliers`` are those of
    DP^p, at a graze of the orbits that miss the wall, NaN at contact loss. ``residual`` is what is left of the
    equations (phases in periods, speeds relative to a fall through the backlash), ``error`` the last change of the
    parameter by Newton's method.
    """

    kind: SpecialKind
    parameter: str
    value: float
    oscillator: Oscillator
    forcing_periods: int
    upper_contacts: int
    lower_contacts: int
    t: np.ndarray
    v: np.ndarray
    multipliers: np.ndarray
    residual: float
    error: float


class Unknowns(NamedTuple):
    """What z = (t, v/v_scale, p/p_scale, ...) stands for; contact loss has no v."""

    oscillator: Oscillator
    parameters: tuple[str, ...]
    scales: np.ndarray
    with_speed: bool = True

    def read(self, z: np.ndarray) -> tuple[Oscillator, float, float] | None:
        """Oscillator, t and v (0 where it is no unknown), or None outside the domain of the map."""
        values = z * self.scales
        first = len(z) - len(self.parameters)
        named = dict(zip(self.parameters, values[first:].tolist(), strict=True))
        try:
            oscillator = check_domain(self.oscillator._replace(**named))
        except OutsideDomain:
            return None
        return oscillator, float(values[0]), float(values[1]) if self.with_speed else 0.0

    def write(self, oscillator: Oscillator, t: float, v: float) -> np.ndarray:
        """The unknowns z of an oscillator and a departure."""
        begin = [t, v] if self.with_speed else [t]
        return np.array(begin + [getattr(oscillator, name) for name in self.parameters]) / self.scales


def nears_edge_of_domain(oscillator: Oscillator) -> bool:
    """Whether the eccentricity is all but at the bound of Eq. (8), beyond which P is not defined."""
    bound = eccentricity_bound_smooth_maxima(oscillator)
    return bool(bound - oscillator.eccentricity < _EDGE * bound)


def unknowns(oscillator: Oscillator, parameters: tuple[str, ...], with_speed: bool = True) -> Unknowns:
    """Unknowns scaled so that 1 is a whole period, a fall through the backlash, the parameter's own value."""
    own = [abs(getattr(oscillator, name)) or oscillator.damping for name in parameters]
    begin = [1.0, float(fall_speed(oscillator))] if with_speed else [1.0]
    return Unknowns(oscillator, parameters, np.array(begin + own), with_speed)


def closing_system(space: Unknowns, shape: OrbitShape, lower: int | None = None) -> System:
    """The two equations of an orbit, with their exact Jacobian.

    Parameters
    ----------
    space : Unknowns
    shape : OrbitShape
    lower : int, optional
        Flights that must meet -beta, as bits; elsewhere the system is not defined.

    Returns
    -------
    System
    """

    def system(z: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        read = space.read(z)
        if read is None:
            return None
        closures = [closure(read[0], name, shape, read[1], read[2]) for name in space.parameters]
        first = closures[0]
        if first is None or (lower is not None and first.lower != lower):
            return None
        columns = [first.jacobian - np.eye(2), *(one.sensitivity[:, None] for one in closures if one is not None)]
        rows = np.array([1.0, space.scales[1]])
        return first.gap / rows, np.hstack(columns) * space.scales / rows[:, None]

    return system


def with_differences(function: Callable[[np.ndarray], np.ndarray | None]) -> System:
    """A system whose Jacobian is taken by central differences."""

    def system(z: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        value = function(z)
        ends = [[function(z + side * _DIFFERENCE * axis) for side in (1, -1)] for axis in np.eye(z.size)]
        if value is None:
            return None
        columns = []
        for ahead, behind in ends:
            if ahead is None or behind is None:
                return None
            columns.append((ahead - behind) / (2.0 * _DIFFERENCE))
        return value, np.column_stack(columns)

    return system


def _special_equation(kind: SpecialKind, space: Unknowns, shape: OrbitShape) -> System:
    def value(z: np.ndarray) -> np.ndarray | None:
        read = space.read(z)
        if read is None:
            return None
        oscillator, t, v = read
        if kind == SpecialKind.GRAZING:
            return np.array([(v - grazing_speed_at(oscillator, t)) / space.scales[1]])
        closed = closure(oscillator, space.parameters[0], shape, t, v)
        multiplier = 1.0 if kind == SpecialKind.SADDLE_NODE else -1.0
        return None if closed is None else np.array([stability_gap(oscillator, shape, closed.jacobian, multiplier)])

    return with_differences(value)


@inlined
def _entry_after(oscillator, t, v):
    """How long after a departure +beta is met again, at which phase and speed."""
    passage = walk(oscillator, t, v, FORWARDS, False, False)
    return passage.flown, passage.rise.phase, passage.rise.velocity


@kernel
def _from_rest(oscillator, t):
    """Departure after rest on the wall at t, and the time until then."""
    stay = follow_contact(oscillator, UPPER, t, 0.0)
    return t + stay.duration, stay.speed, stay.duration


@kernel
def _touch_gap(oscillator, shape, t):
    """Depth and its rate of the orbit's last stay the time m after rest on the wall at t; NaN where it is never met."""
    here, speed, elapsed = _from_rest(oscillator, t)
    for _ in range(shape.upper_contacts - 2):
        impact = next_impact(oscillator, here, speed)
        here, speed = impact.t, impact.v
        elapsed += impact.duration
    if not speed > 0.0:
        return math.nan, math.nan
    flight, phase, velocity = _entry_after(oscillator, here, speed)
    stay = enter_contact(oscillator, UPPER, phase, 0.0, velocity)
    motion = state_in_contact(stay, shape.forcing_periods - elapsed - flight)
    return motion.depth, motion.rate


@kernel
def _shallowest(oscillator, t, v):
    """Phase of the least depth inside any stay beyond +beta that follows these departures; NaN where none has one."""
    least, phase = math.inf, math.nan
    for i in range(t.size):
        elapsed, begins, velocity = _entry_after(oscillator, t[i], v[i])
        length = next_impact(oscillator, t[i], v[i]).duration - elapsed
        stay = enter_contact(oscillator, UPPER, begins, 0.0, velocity)
        falling = False
        for n in range(1, _SAMPLES):
            motion = state_in_contact(stay, length * n / _SAMPLES)
            if falling and motion.rate >= 0.0 and motion.depth < least:
                least, phase = motion.depth, begins + length * n / _SAMPLES
            falling = motion.rate < 0.0
    return phase


def shallowest_in_contact(oscillator: Oscillator, t: np.ndarray, v: np.ndarray) -> float:
    """Phase at which the stays after these departures come closest to leaving +beta between their ends.

    Parameters
    ----------
    oscillator : Oscillator
        Of finite stiffness, checked by the caller.
    t, v : ndarray of float64, shape (n,)

    Returns
    -------
    float
        NaN where no stay has a minimum inside.
    """
    return float(_shallowest(oscillator, t, v))


def special_system(kind: SpecialKind, space: Unknowns, shape: OrbitShape, lower: int | None = None) -> System:
    """All equations of a special point: one less than the unknowns of a curve, as many as those of a point.

    Parameters
    ----------
    kind : SpecialKind
    space : Unknowns
        With speed, except for contact loss.
    shape : OrbitShape
        ``over`` for a graze; for contact loss ``upper_contacts`` counts the departure of speed 0.
    lower : int, optional
        As for `closing_system`; not used for contact loss.

    Returns
    -------
    System
    """
    if kind == SpecialKind.CONTACT_LOSS:
        return with_differences(_touch_equations(space, shape))
    closing, special = closing_system(space, shape, lower), _special_equation(kind, space, shape)

    def system(z: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        orbit, one = closing(z), special(z)
        if orbit is None or one is None:
            return None
        return np.concatenate([orbit[0], one[0]]), np.vstack([orbit[1], one[1]])

    return system


def _touch_equations(space: Unknowns, shape: OrbitShape) -> Callable[[np.ndarray], np.ndarray | None]:
    scale = float(fall_speed(space.oscillator))

    def value(z: np.ndarray) -> np.ndarray | None:
        read = space.read(z)
        if read is None or math.isinf(read[0].stiffness):
            return None
        depth, rate = _touch_gap(read[0], shape, read[1])
        gap = np.array([depth * math.sqrt(2.0 * read[0].stiffness), rate]) / scale
        return gap if np.isfinite(gap).all() else None

    return value


def locate(
    kind: SpecialKind, oscillator: Oscillator, parameter: str, shape: OrbitShape, t: float, v: float
) -> SpecialPoint | None:
    """Locate a special point from a guess.

    Parameters
    ----------
    kind : SpecialKind
    oscillator : Oscillator
        With the guess of the parameter.
    parameter : str
        The field to solve for.
    shape : OrbitShape
        As for `special_system`.
    t, v : float
        Guess of a departure of the orbit: for a graze the one that grazes, for contact loss the touch (its v is 0).

    Returns
    -------
    SpecialPoint or None
        None where Newton's method does not converge from here.
    """
    space = unknowns(oscillator, (parameter,), kind != SpecialKind.CONTACT_LOSS)
    system = special_system(kind, space, shape)
    solution = solve(system, space.write(oscillator, t, v))
    if solution is None:
        return None
    evaluated, read = system(solution.z), space.read(solution.z)
    if evaluated is None or read is None:
        return None
    error = solution.last_step * space.scales[-1]
    return describe_point(kind, parameter, shape, *read, float(np.abs(evaluated[0]).max()), float(error))


def describe_point(
    kind: SpecialKind,
    parameter: str,
    shape: OrbitShape,
    oscillator: Oscillator,
    t: float,
    v: float,
    residual: float,
    error: float,
) -> SpecialPoint:
    """Special point from a solution of its equations: all departures and the multipliers.

    Parameters
    ----------
    kind, parameter, shape
        As for `locate`.
    oscillator : Oscillator
        With the parameter's value found.
    t, v : float
        The first departure.
    residual, error : float
        As in `SpecialPoint`.

    Returns
    -------
    SpecialPoint
    """
    multipliers = np.full(2, np.nan, complex)
    if kind == SpecialKind.CONTACT_LOSS:
        here, speed, _ = _from_rest(oscillator, t)
        rest = shape._replace(upper_contacts=shape.upper_contacts - 1)
        times, speeds, lower = orbit_from(oscillator, rest, here, speed)
        times, speeds = np.append(wrap(t), times), np.append(0.0, speeds)
    else:
        times, speeds, lower = orbit_from(oscillator, shape, t, v)
        closed = closure(oscillator, parameter, shape, t, v)
        if closed is not None:
            multipliers = np.linalg.eigvals(closed.jacobian).astype(complex)
    return SpecialPoint(
        kind, parameter, getattr(oscillator, parameter), oscillator, shape.forcing_periods, shape.upper_contacts,
        lower, times, speeds, multipliers, residual, error,
    )  # fmt: skip
