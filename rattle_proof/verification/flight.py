"""Enclosures of flights: where and how fast all departures of a box arrive, and how low they fall.

A flight that leaves a wall at time t with velocity w is after tau, counted from that wall,

    y  = 4 pi tau + e(t + tau) - e(t) + (w - 4 pi - e'(t)) E,    y' = 4 pi + e'(t + tau) + (w - 4 pi - e'(t)) D.

The duration is sought by Newton's method with the departure as a parameter: N = tau - y(tau)/y'(T), where y(tau) is
enclosed over the box in its mean value form. If N lies inside T, every departure of the box has just one root in T, and
that root lies in N.
"""

from collections.abc import Callable
from typing import NamedTuple, Protocol, TypeVar

from flint import arb

from rattle_proof.verification.machine import Machine, within

_TRIES = 8
_WIDER = 1.25
_TINY = 2.0**-60
_PASSES = 6


class Slope(NamedTuple):
    """Derivative of (time, speed or velocity) by (time, speed or velocity)."""

    tt: arb
    tv: arb
    vt: arb
    vv: arb

    def times(self, other: "Slope") -> "Slope":
        """Product of two."""
        return Slope(
            self.tt * other.tt + self.tv * other.vt,
            self.tt * other.tv + self.tv * other.vv,
            self.vt * other.tt + self.vv * other.vt,
            self.vt * other.tv + self.vv * other.vv,
        )

    def of(self, dt: arb, dv: arb) -> tuple[arb, arb]:
        """Image of a difference."""
        return self.tt * dt + self.tv * dv, self.vt * dt + self.vv * dv


class Departures(NamedTuple):
    """A point near the middle of a box, all of the box, as balls of times and of velocities (or speeds)."""

    t: arb
    w: arb
    all_t: arb
    all_w: arb


class Arrivals(NamedTuple):
    """The middle's arrival, that of all, the derivative over the box, and how long any of them takes."""

    t: arb
    w: arb
    all_t: arb
    all_w: arb
    slope: Slope
    tau: arb


class Turn(NamedTuple):
    """Turning points of a box: times, heights over the wall that was left."""

    t: arb
    height: arb


class Motion(Protocol):
    """What motions from one ball of departures have in common, by the time since."""

    def height(self, tau: arb) -> arb:
        """Displacement from where they began."""

    def velocity(self, tau: arb) -> arb:
        """Its rate."""

    def height_slopes(self, tau: arb) -> tuple[arb, arb]:
        """Derivatives of the displacement at a given tau by departure time and velocity."""

    def arrival_slope(self, tau: arb, velocity: arb) -> Slope:
        """Derivative of (time, velocity) at a given displacement by the departure."""


class Flight:
    """What flights from one ball of departures have in common."""

    def __init__(self, machine: Machine, t: arb, w: arb) -> None:
        self.machine, self.t, self.w = machine, t, w
        self.error, self.rate, self.bend = machine.error(t)
        self.felt = machine.damping * (4 * arb.pi() + self.rate) + self.bend
        self.lag = w - 4 * arb.pi() - self.rate

    def height(self, tau: arb) -> arb:
        """Displacement y."""
        reached, _ = self.machine.decay(tau)
        value, _, _ = self.machine.error(self.t + tau)
        return 4 * arb.pi() * tau + value - self.error + self.lag * reached

    def velocity(self, tau: arb) -> arb:
        """Velocity y'."""
        _, left = self.machine.decay(tau)
        _, rate, _ = self.machine.error(self.t + tau)
        return 4 * arb.pi() + rate + self.lag * left

    def height_slopes(self, tau: arb) -> tuple[arb, arb]:
        """Derivatives of y at a given tau by departure time and velocity."""
        reached, _ = self.machine.decay(tau)
        _, rate, _ = self.machine.error(self.t + tau)
        return rate - self.rate - self.bend * reached, reached

    def velocity_slopes(self, tau: arb) -> tuple[arb, arb]:
        """Derivatives of y' at a given tau by departure time and velocity."""
        _, left = self.machine.decay(tau)
        _, _, bend = self.machine.error(self.t + tau)
        return bend - self.bend * left, left

    def acceleration(self, tau: arb) -> arb:
        """Acceleration y''."""
        return self.machine.acceleration(self.t + tau) - self.machine.damping * self.velocity(tau)

    def arrival_slope(self, tau: arb, velocity: arb) -> Slope:
        """Derivative of (arrival time, y') by the departure."""
        reached, left = self.machine.decay(tau)
        s_t = (self.w * left + self.felt * reached) / velocity
        s_w = -reached / velocity
        bend = self.machine.acceleration(self.t + tau) - self.machine.damping * velocity
        return Slope(s_t, s_w, bend * s_t - left * (self.felt - self.machine.damping * self.w), bend * s_w + left)


Some = TypeVar("Some", bound=Motion)
Function = Callable[[Some, arb], arb]


def _velocity(motion: Motion, tau: arb) -> arb:
    return motion.velocity(tau)


def _height_slopes(motion: Motion, tau: arb) -> tuple[arb, arb]:
    return motion.height_slopes(tau)


def _root(
    start: Some, wide: Some, offset: tuple[arb, arb], guess: arb,
    value: Function[Some], slopes: Callable[[Some, arb], tuple[arb, arb]], rate: Function[Some],
) -> arb | None:  # fmt: skip
    """The root of a function of the duration, for all departures; None where it cannot be enclosed."""
    by_t, by_w = slopes(wide, guess)
    missed = value(start, guess) + by_t * offset[0] + by_w * offset[1]
    found = guess - missed / rate(start, guess)
    for _ in range(_TRIES):
        far = (found - guess).abs_upper()
        sought = guess + arb(0, far * _WIDER + guess.abs_upper() * _TINY)
        slope = rate(wide, sought)
        if slope.contains(0) or not slope.is_finite():
            return None
        found = guess - missed / slope
        if sought.contains_interior(found):
            return found if found > 0 else None
    return None


def _middle_root(start: Some, guess: float, value: Function[Some], rate: Function[Some]) -> arb | None:
    """The root for the middle, as sharp as the digits allow."""
    at, best = arb(guess), None
    for _ in range(_PASSES):
        found = _root(start, start, (arb(0), arb(0)), at, value, lambda motion, tau: (arb(0), arb(0)), rate)
        if found is None or (best is not None and found.rad() > best.rad() / 4):
            break
        at, best = found.mid(), found
    return found if best is None else best


def arrive(
    motion: Callable[[arb, arb], Motion], box: Departures, height: arb, guess: float, upwards: bool
) -> Arrivals | None:
    """Enclose the arrivals of a box at a height over the wall that it left.

    Parameters
    ----------
    motion : callable
        The motions from balls of times and velocities.
    box : Departures
    height : arb
    guess : float
        Duration of the middle's flight, about. Nothing rests on it.
    upwards : bool
        The sign that the velocity is to have there.

    Returns
    -------
    Arrivals or None
        None where nothing is proven.
    """
    start, wide = motion(box.t, box.w), motion(box.all_t, box.all_w)

    def value(motion: Motion, tau: arb) -> arb:
        return motion.height(tau) - height

    middle = _middle_root(start, guess, value, _velocity)
    if middle is None:
        return None
    offset = box.all_t - box.t, box.all_w - box.w
    tau = _root(start, wide, offset, middle.mid(), value, _height_slopes, _velocity)
    if tau is None:
        return None
    velocity = wide.velocity(tau)
    if not (velocity > 0 if upwards else velocity < 0):
        return None
    slope = wide.arrival_slope(tau, velocity)
    later, faster = slope.of(*offset)
    t, w = box.t + middle, start.velocity(middle)
    return Arrivals(t, w, within(t + later, box.all_t + tau), within(w + faster, velocity), slope, tau)


def turning(machine: Machine, box: Departures, guess: float) -> Turn | None:
    """Enclose the turning points of flights downwards. Where y' = 0, y'' = a > 0: each has one, its lowest point."""
    start, wide = Flight(machine, box.t, box.w), Flight(machine, box.all_t, box.all_w)
    middle = _middle_root(start, guess, Flight.velocity, Flight.acceleration)
    if middle is None:
        return None
    offset = box.all_t - box.t, box.all_w - box.w
    tau = _root(start, wide, offset, middle.mid(), Flight.velocity, Flight.velocity_slopes, Flight.acceleration)
    if tau is None:
        return None
    # At the lowest point the height does not change with the duration.
    reached, left = machine.decay(tau)
    change = reached * offset[1] - (wide.w * left + wide.felt * reached) * offset[0]
    return Turn(box.all_t + tau, start.height(middle) + change)
