"""The equations of bifurcation points: the orbit closes, and one more condition for each kind of point."""

import math
from collections.abc import Callable
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.apply import next_impact, walk
from rattle_kernels.impact_map.flights import FORWARDS, UPPER
from rattle_kernels.model.contact import enter_contact, state_in_contact
from rattle_kernels.model.contact_end import follow_contact
from rattle_kernels.model.domain import OutsideDomain, check_domain, check_oscillator, closed_edges
from rattle_kernels.model.flight import fall_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import inlined, kernel
from rattle_kernels.numerics.pseudo_arclength import System
from rattle_kernels.orbits.closure import OrbitShape, closure, grazing_speed_at, stability_gap

# Step of central differences. The quantities are known to about 1e-13: truncation 1e-12, round-off 1e-7.
_DIFFERENCE = 1e-6
# Scaled parameters so close beyond a closed edge of their domain are rounded; so close to it, a curve has come to it.
_ROUNDED, _AT_EDGE = 1e-12, 1e-8


class SpecialKind(StrEnum):
    """Kinds of special points."""

    SADDLE_NODE = "saddle-node"
    PERIOD_DOUBLING = "period doubling"
    GRAZING = "grazing"
    CONTACT_LOSS = "contact loss"
    UPPER_GRAZING = "upper grazing"
    RELEASE = "release"


def check_followed(oscillator: Oscillator) -> Oscillator:
    """Return an oscillator whose orbits can be followed, or raise: with finite stiffness beyond the bound of Eq. (8).

    Raises
    ------
    OutsideDomain
    """
    checked = check_oscillator(oscillator)
    return checked if math.isinf(checked.stiffness) else check_domain(checked)


class Unknowns(NamedTuple):
    """Meaning of z = (t, v/v_scale, p/p_scale, ...). Contact loss has no v."""

    oscillator: Oscillator
    parameters: tuple[str, ...]
    scales: np.ndarray
    with_speed: bool = True

    def read(self, z: np.ndarray) -> tuple[Oscillator, float, float] | None:
        """Oscillator, t and v of z; v is 0 if it is not an unknown. None outside the domain of the map."""
        values = z * self.scales
        first = len(z) - len(self.parameters)
        inside = self.within(z) * self.scales
        values = np.where(np.abs(inside - values) <= _ROUNDED * self.scales, inside, values)
        named = dict(zip(self.parameters, values[first:].tolist(), strict=True))
        try:
            oscillator = check_followed(self.oscillator.at(**named))
        except OutsideDomain:
            return None
        return oscillator, float(values[0]), float(values[1]) if self.with_speed else 0.0

    def within(self, z: np.ndarray) -> np.ndarray:
        """The nearest z whose parameters are not beyond a closed edge of their domain."""
        first = len(z) - len(self.parameters)
        low, high = np.array([closed_edges(name) for name in self.parameters]).T / self.scales[first:]
        return np.concatenate([z[:first], np.clip(z[first:], low, high)])

    def edge_near(self, z: np.ndarray) -> np.ndarray | None:
        """The z on a closed edge that a parameter of z has come to, and 1 for that parameter; None if none has."""
        first = len(z) - len(self.parameters)
        for place, name in enumerate(self.parameters, first):
            for edge in closed_edges(name):
                if abs(z[place] - edge / self.scales[place]) <= _AT_EDGE:
                    along = np.eye(len(z))[place]
                    return np.array([z + (edge / self.scales[place] - z[place]) * along, along])
        return None

    def write(self, oscillator: Oscillator, t: float, v: float) -> np.ndarray:
        """Unknowns z of an oscillator and a departure."""
        begin = [t, v] if self.with_speed else [t]
        return np.array(begin + [oscillator.value_of(name) for name in self.parameters]) / self.scales


def unknowns(oscillator: Oscillator, parameters: tuple[str, ...], with_speed: bool = True) -> Unknowns:
    """Unknowns in units of a forcing period, the speed of a fall through the backlash and the parameter's own value."""
    own = [abs(oscillator.value_of(name)) or oscillator.damping for name in parameters]
    begin = [1.0, float(fall_speed(oscillator))] if with_speed else [1.0]
    return Unknowns(oscillator, parameters, np.array(begin + own), with_speed)


def closing_system(space: Unknowns, shape: OrbitShape, lower: tuple[int, ...] | None = None) -> System:
    """The two equations of an orbit, with their exact Jacobian.

    Parameters
    ----------
    space : Unknowns
    shape : OrbitShape
    lower : tuple of int, optional
        How often -beta must be met on each way from +beta to +beta. For any others the system is undefined.

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


def with_differences(function: Callable[[np.ndarray], np.ndarray | None], space: Unknowns) -> System:
    """System with a Jacobian by central differences, one-sided ones on a closed edge of the domain."""

    def system(z: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        value = function(z)
        if value is None:
            return None
        columns = []
        for place, axis in enumerate(np.eye(z.size)):
            places = [z + side * _DIFFERENCE * axis for side in (1, -1)]
            inside = [space.within(each) for each in places]
            ahead, behind = function(inside[0]), function(inside[1])
            if ahead is None or behind is None:
                return None
            lost = sum(abs(there[place] - here[place]) for there, here in zip(places, inside, strict=True))
            columns.append((ahead - behind) / (2.0 * _DIFFERENCE - lost))
        return value, np.column_stack(columns)

    return system


def _special_equation(kind: SpecialKind, space: Unknowns, shape: OrbitShape) -> System:
    def value(z: np.ndarray) -> np.ndarray | None:
        read = space.read(z)
        if read is None:
            return None
        oscillator, t, v = read
        if kind == SpecialKind.GRAZING:
            if oscillator.is_loose:  # no flight passes -beta as if it were not there
                return None
            return np.array([(v - grazing_speed_at(oscillator, t)) / space.scales[1]])
        closed = closure(oscillator, space.parameters[0], shape, t, v)
        multiplier = 1.0 if kind == SpecialKind.SADDLE_NODE else -1.0
        return None if closed is None else np.array([stability_gap(oscillator, shape, closed.jacobian, multiplier)])

    return with_differences(value, space)


@inlined
def entry_after(oscillator, t, v):
    """Time from a departure to the next contact with +beta, and the phase and velocity there."""
    passage = walk(oscillator, t, v, FORWARDS, over=False, reduces=False)
    return passage.flown, passage.rise.phase, passage.rise.velocity


@kernel
def from_rest(oscillator, t):
    """Phase and speed of the departure that follows rest on the wall at t, and the time between."""
    stay = follow_contact(oscillator, UPPER, t, 0.0)
    return t + stay.duration, stay.speed, stay.duration


@kernel
def _touch_gap(oscillator, shape, t):
    """Depth and its rate in the orbit's last contact, a time m after rest on the wall at t; NaN if there is none."""
    here, speed, elapsed = from_rest(oscillator, t)
    for _ in range(shape.upper_contacts - 2):
        impact = next_impact(oscillator, here, speed)
        here, speed = impact.t, impact.v
        elapsed += impact.duration
    if not speed > 0.0:
        return math.nan, math.nan
    flight, phase, velocity = entry_after(oscillator, here, speed)
    stay = enter_contact(oscillator, UPPER, phase, 0.0, velocity)
    motion = state_in_contact(stay, shape.forcing_periods - elapsed - flight)
    return motion.depth, motion.rate


def together(some: System, more: System) -> System:
    """System of the equations of two systems in the same unknowns.

    Parameters
    ----------
    some, more : callable

    Returns
    -------
    System
        Undefined where one of them is.
    """

    def system(z: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        first = some(z)
        second = None if first is None else more(z)
        if first is None or second is None:
            return None
        return np.concatenate([first[0], second[0]]), np.vstack([first[1], second[1]])

    return system


def special_system(
    kind: SpecialKind, space: Unknowns, shape: OrbitShape, lower: tuple[int, ...] | None = None
) -> System:
    """All equations of a special point: as many as the unknowns of a point, one fewer than those of a curve.

    Parameters
    ----------
    kind : SpecialKind
    space : Unknowns
        With speed, except for contact loss.
    shape : OrbitShape
        With ``over`` for a graze. For contact loss ``upper_contacts`` includes the departure of speed 0.
    lower : tuple of int, optional
        As in `closing_system`. Not used for contact loss.

    Returns
    -------
    System
    """
    if kind == SpecialKind.CONTACT_LOSS:
        return with_differences(_touch_equations(space, shape), space)
    return together(closing_system(space, shape, lower), _special_equation(kind, space, shape))


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
