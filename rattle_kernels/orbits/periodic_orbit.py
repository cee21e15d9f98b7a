"""Periodic orbits of P: Newton's method on P^p, multipliers, itinerary P(m, n+, n-).

An orbit of impact period p returns to +beta p times (n+ = p) in m forcing periods; n- counts its contacts with -beta.
Its multipliers are the eigenvalues of DP^p. It attracts if both lie inside the unit circle.

The product of the multipliers is e^{-delta m} in both models. The flow of (Phi, Phi') contracts areas like e^{-delta t}
everywhere, and an elastic impact preserves them. On the section the flow carries the area v dv dt, so det DP = (v0/v1)
e^{-delta T}. Hence a complex pair always lies inside the unit circle: there is no Neimark-Sacker bifurcation. The trace
decides everything. Stability is lost at a multiplier +1 (trace = 1 + e^{-delta m}) or -1 (trace = -1 - e^{-delta m}).

An orbit of a loose gear that comes to rest is superstable: both multipliers are 0. Its name has a star.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.apply import next_impact
from rattle_kernels.impact_map.jacobian import next_impact_with_jacobian
from rattle_kernels.impact_map.variations import Jacobian, multiply
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.jit import inlined, kernel
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.numerics.phase import part_turn, wrap, wrap_all

NEWTON_ROUNDS = 40
# Largest distance from an orbit, in periods and the scale of speeds, at which Newton's method has reached it.
_DISTANCE = 1e-11
# Largest residual of an orbit, or this much for its multiplier; and that of its other departures.
_RESIDUAL, _ROUNDING, _RETURNS = 1e-11, 1e-13, 1e-10
# Between two rests rounding grows by so much at most. Beyond that it decides where the next rest is.
_RESOLVED = 1e8
# Longer orbits are followed for one turn alone, from their first departure: p turns take p^2 impacts.
_CHECKED_ONE_BY_ONE = 64
# Impacts between two pauses, if a round takes no more: milliseconds, but in the softest contacts most of a second.
_IMPACTS_A_LEG = 512


def orbit_name(forcing_periods: int, upper_contacts: int, lower_contacts: int, *, rests: bool = False) -> str:
    """``P(m, n+, n-)``, the name of a periodic orbit (Sec. 4); with a star if it comes to rest."""
    return f"P({forcing_periods},{upper_contacts},{lower_contacts}){'*' if rests else ''}"


class PeriodicOrbit(NamedTuple):
    """A periodic orbit to which Newton's method has converged, and to which the map returns.

    ``t``, ``v`` (shape (upper_contacts,)) are its departures from +beta in order of time, the slowest first.
    ``jacobians`` (shape (upper_contacts, 2, 2)) are DP^p at each of them. ``residual`` is ``|P^p(x) - x|``
    of the departure that it was found from.
    """

    t: np.ndarray
    v: np.ndarray
    forcing_periods: int
    upper_contacts: int
    lower_contacts: int
    jacobians: np.ndarray
    residual: float

    @property
    def name(self) -> str:
        """``P(m, n+, n-)``, with a star if it comes to rest."""
        return orbit_name(self.forcing_periods, self.upper_contacts, self.lower_contacts, rests=self.rests)

    @property
    def rests(self) -> bool:
        """Whether it comes to rest on a wall in every turn."""
        return not self.jacobians.any()

    @property
    def multipliers(self) -> np.ndarray:
        """Eigenvalues of DP^p, complex, shape (2,)."""
        return np.linalg.eigvals(self.jacobians[0]).astype(complex)

    @property
    def attracts(self) -> bool:
        """Whether both multipliers lie inside the unit circle."""
        return bool(np.abs(self.multipliers).max() < 1.0)

    @property
    def lyapunov_exponent(self) -> float:
        """Largest Lyapunov exponent, per forcing period; -infinity where both multipliers are 0 (superstable)."""
        largest = np.abs(self.multipliers).max()
        return float(np.log(largest) / self.forcing_periods) if largest > 0.0 else -math.inf


@inlined
def iterate(oscillator, t, v, period):
    """P^p with its derivative, the elapsed time and the number of contacts with -beta.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : float
        A departure from +beta: finite, v > 0.
    period : int
        p.

    Returns
    -------
    (float, float, Jacobian, float, int)
        Phase and speed, not a number where contact is permanent; DP^p, the time that it took, the contacts.
    """
    jacobian = Jacobian(1.0, 0.0, 0.0, 1.0)
    elapsed, lower = 0.0, 0
    for _ in range(period):
        impact, one = next_impact_with_jacobian(oscillator, t, v)
        jacobian = multiply(one, jacobian)
        t, v = impact.t, impact.v
        elapsed += impact.duration
        lower += impact.lower_impacts
        if not math.isfinite(t):  # contact is permanent; from nowhere a search for the next impact takes 30 ms
            break
    return t, v, jacobian, elapsed, lower


@inlined
def _size(jacobian):
    """Greatest multiplier, or 1 if none is greater: what an error of a departure grows to in a turn, where it grows."""
    return max(1.0, abs(jacobian.tt + jacobian.vv))


@inlined
def _forgets(jacobian):
    """Whether a motion comes to rest, after which nothing is left of where it was."""
    return jacobian.tt == 0.0 and jacobian.tv == 0.0 and jacobian.vt == 0.0 and jacobian.vv == 0.0


@kernel
def newton_rounds(oscillator, t, v, period, scale, rounds):
    """Some rounds of Newton's method on P^p(x) - x: phase, speed, distance from an orbit before the last step, the end.

    The distance is the residual over the greatest multiplier. Steps that would make v <= 0 are halved. A step of more
    than a period leads nowhere: the method ends there, with an infinite distance.
    """
    distance = math.inf
    for _ in range(rounds):
        t1, v1, jacobian, _, _ = iterate(oscillator, t, v, period)
        f = part_turn(t1 - t)
        g = v1 - v
        distance = math.hypot(f, g / scale) / _size(jacobian)
        if _forgets(jacobian):  # the release is on the orbit itself
            if f == 0.0 and g == 0.0:
                return t, v, distance, True
            t, v = t1, v1
            continue
        if not distance > 1e-15:
            return t, v, distance, True
        a, b, c, d = jacobian.tt - 1.0, jacobian.tv, jacobian.vt, jacobian.vv - 1.0
        determinant = a * d - b * c
        dt, dv = (b * g - d * f) / determinant, (c * f - a * g) / determinant
        if not (abs(dt) <= 1.0 and math.isfinite(dv)):
            return t, v, math.inf, True
        while v + dv <= 0.0:
            dt, dv = 0.5 * dt, 0.5 * dv
        t, v = wrap(t + dt), v + dv
        if math.hypot(dt, dv / scale) < 1e-15:
            return t, v, distance, True
    return t, v, distance, False


def newton_orbit(
    oscillator: Oscillator, t: float, v: float, period: int, scale: float, pause: Pause
) -> tuple[float, float, float]:
    """Newton's method from one seed, whatever its period: phase, speed and distance from an orbit."""
    ended, rounds, t = False, NEWTON_ROUNDS, float(wrap_all(np.array([t]))[0])
    while rounds > 0 and not ended:
        pause()
        now = min(rounds, max(1, _IMPACTS_A_LEG // period))
        t, v, distance, ended = newton_rounds(oscillator, t, v, period, scale, now)
        rounds -= now
    return t, v, distance


@inlined
def _write(jacobian, matrix):
    matrix[0, 0], matrix[0, 1] = jacobian.tt, jacobian.tv
    matrix[1, 0], matrix[1, 1] = jacobian.vt, jacobian.vv


@inlined
def _read(matrix):
    return Jacobian(matrix[0, 0], matrix[0, 1], matrix[1, 0], matrix[1, 1])


@kernel
def _orbit_points(oscillator, t, v, period, times, speeds, steps, jacobians):
    """Fill in the points of the orbit and DP^p at each. Returns the time and the contacts with -beta of one turn."""
    elapsed, lower = 0.0, 0
    before = Jacobian(1.0, 0.0, 0.0, 1.0)
    for i in range(period):
        times[i], speeds[i] = t, v
        _write(before, jacobians[i])
        impact, one = next_impact_with_jacobian(oscillator, t, v)
        _write(one, steps[i])
        before = multiply(one, before)
        elapsed += impact.duration
        lower += impact.lower_impacts
        t, v = impact.t, impact.v
    # DP^p at point i: from i to the end, then from the start to i.
    onward = Jacobian(1.0, 0.0, 0.0, 1.0)
    for i in range(period - 1, -1, -1):
        onward = multiply(onward, _read(steps[i]))
        _write(multiply(_read(jacobians[i]), onward), jacobians[i])
    return elapsed, lower


def find_periodic_orbit(
    oscillator: Oscillator, t: float, v: float, period: int, scale: float, *, pause: Pause = never_stopped
) -> PeriodicOrbit | None:
    """Periodic orbit near a seed, if there is one.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : float
        Seed: phase and speed of a departure from +beta.
    period : int
        Impact period p. If the orbit's own period is a divisor of p, that one is used.
    scale : float
        Speed that counts as much as one forcing period.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    PeriodicOrbit or None
        None if Newton's method reaches none, or ends at rest on the wall; or if a loose gear moves so irregularly
        between two rests that rounding decides where the next one is. The departures that are stored return to
        themselves, by P and with reduced phases: within 1e-10 times the greatest multiplier, if that is above 1.
    """
    t, v, distance = newton_orbit(oscillator, t, v, period, scale, pause)
    if not distance <= _DISTANCE:
        return None
    period = _own_period(oscillator, t, v, period, scale)
    times, speeds = np.empty(period), np.empty(period)
    steps, jacobians = np.empty((period, 2, 2)), np.empty((period, 2, 2))
    elapsed, lower = _orbit_points(oscillator, t, v, period, times, speeds, steps, jacobians)
    if not (math.isfinite(elapsed) and round(elapsed) >= 1):
        return None  # the limit v -> 0, where every phase maps to itself, is not an orbit
    if not jacobians.any() and _largest_error(steps, scale) > _RESOLVED:
        return None
    multiplier = float(np.abs(np.linalg.eigvals(jacobians[0])).max())
    residual = _residual(oscillator, times, speeds, scale, multiplier, pause)
    if residual is None:
        return None
    first = int(np.argmin(speeds))
    return PeriodicOrbit(
        np.roll(times, -first), np.roll(speeds, -first), round(elapsed), period, int(lower),
        np.roll(jacobians, -first, axis=0), residual,
    )  # fmt: skip


def _largest_error(steps: np.ndarray, scale: float) -> float:
    """What an error on a superstable orbit grows to until the rest that forgets it, for the worst place on the way."""
    rest = int(np.flatnonzero(~steps.any(axis=(1, 2)))[-1])
    onward, largest, units = np.eye(2), 1.0, np.array([[1.0, scale], [1.0 / scale, 1.0]])
    for step in np.roll(steps, -rest - 1, axis=0)[-2::-1]:
        onward = onward @ (units * step)
        largest = max(largest, float(np.abs(onward).max()))
    return largest


@kernel
def _gap(oscillator, t, v, period, scale):
    """Distance between a departure and P^p of it, by P alone and with reduced phases."""
    here, speed = t, v
    for _ in range(period):
        impact = next_impact(oscillator, here, speed)
        if impact.outcome != OUTCOME_RETURNED:
            return math.inf
        here, speed = impact.t, impact.v
    return math.hypot(part_turn(here - t), (speed - v) / scale)


def _residual(
    oscillator: Oscillator, times: np.ndarray, speeds: np.ndarray, scale: float, multiplier: float, pause: Pause
) -> float | None:
    """|P^p(x) - x| of the first of these departures; None if the map does not return to each of them.

    Rounding grows with the multiplier M. Near a graze, where DP is steep, P is linear within 1/M^2 only: a residual of
    more than 1/M does not show an orbit.
    """
    size, period = max(1.0, multiplier), times.size
    residual = _gap(oscillator, times[0], speeds[0], period, scale)
    if not residual <= max(_RESIDUAL, min(_ROUNDING * size, 0.1 / size)):
        return None
    for i in range(1, period if period <= _CHECKED_ONE_BY_ONE else 1):
        pause()
        if _gap(oscillator, times[i], speeds[i], period, scale) > _RETURNS * size:
            # Carried here, the first departure's rounding has grown: this one by itself.
            times[i], speeds[i], _, _ = newton_rounds(oscillator, times[i], speeds[i], period, scale, 4)
            if not _gap(oscillator, times[i], speeds[i], period, scale) <= _RETURNS * size:
                return None
    return float(residual)


@kernel
def _derivatives(oscillator, t, v, derivatives):
    for i in range(t.size):
        _, one = next_impact_with_jacobian(oscillator, t[i], v[i])
        _write(one, derivatives[i])


def derivatives_along(oscillator: Oscillator, orbit: PeriodicOrbit) -> np.ndarray:
    """DP at every point of an orbit.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    orbit : PeriodicOrbit

    Returns
    -------
    ndarray of float64, shape (upper_contacts, 2, 2)
    """
    derivatives = np.empty((orbit.upper_contacts, 2, 2))
    _derivatives(oscillator, orbit.t, orbit.v, derivatives)
    return derivatives


@kernel
def _distance_after(oscillator, t, v, divisor, scale):
    """Distance from an orbit of this impact period."""
    t1, v1, jacobian, _, _ = iterate(oscillator, t, v, divisor)
    return math.hypot(part_turn(t1 - t), (v1 - v) / scale) / _size(jacobian)


def _own_period(oscillator: Oscillator, t: float, v: float, period: int, scale: float) -> int:
    for divisor in range(1, period // 2 + 1):
        if period % divisor == 0 and _distance_after(oscillator, t, v, divisor, scale) < 1e-9:
            return divisor
    return period
