"""Periodic orbits of P: Newton's method on P^p, multipliers, itinerary P(m, n+, n-).

An orbit of impact period p returns to +beta p times (n+ = p) in m forcing periods; n- counts its contacts with -beta.
Its multipliers are the eigenvalues of DP^p. It attracts if both lie inside the unit circle.

The product of the multipliers is e^{-delta m} in both models. The flow of (Phi, Phi') contracts areas like e^{-delta t}
everywhere, and an elastic impact preserves them. On the section the flow carries the area v dv dt, so det DP = (v0/v1)
e^{-delta T}. Hence a complex pair always lies inside the unit circle: there is no Neimark-Sacker bifurcation. The trace
decides everything. Stability is lost at a multiplier +1 (trace = 1 + e^{-delta m}) or -1 (trace = -1 - e^{-delta m}).
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.jacobian import Jacobian, multiply, next_impact_with_jacobian
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import inlined, kernel
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.numerics.phase import part_turn, wrap_all

NEWTON_ROUNDS = 40
_RESIDUAL = 1e-11
# Impacts between two pauses, if a round takes no more: milliseconds, but in the softest contacts most of a second.
_IMPACTS_A_LEG = 512


class PeriodicOrbit(NamedTuple):
    """A periodic orbit to which Newton's method has converged.

    ``t``, ``v`` (shape (upper_contacts,)) are its departures from +beta in order of time, the slowest first.
    ``jacobians`` (shape (upper_contacts, 2, 2)) are DP^p at each of them. ``residual`` is ``|P^p(x) - x|``.
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
        """``P(m, n+, n-)``."""
        return f"P({self.forcing_periods},{self.upper_contacts},{self.lower_contacts})"

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
        """Largest Lyapunov exponent, per forcing period."""
        return float(np.log(np.abs(self.multipliers).max()) / self.forcing_periods)


@inlined
def _iterate(oscillator, t, v, period):
    """P^p with its derivative, the elapsed time and the number of contacts with -beta."""
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


@kernel
def newton_rounds(oscillator, t, v, period, scale, rounds):
    """Some rounds of Newton's method on P^p(x) - x: phase and speed, the residual before the last step, if it ended.

    Steps that would make v <= 0 are halved. The phase is not reduced.
    """
    residual = math.inf
    for _ in range(rounds):
        t1, v1, jacobian, _, _ = _iterate(oscillator, t, v, period)
        f = part_turn(t1 - t)
        g = v1 - v
        residual = math.hypot(f, g / scale)
        if not residual > 1e-15:
            return t, v, residual, True
        a, b, c, d = jacobian.tt - 1.0, jacobian.tv, jacobian.vt, jacobian.vv - 1.0
        determinant = a * d - b * c
        dt, dv = (b * g - d * f) / determinant, (c * f - a * g) / determinant
        if not (math.isfinite(dt) and math.isfinite(dv)):
            return t, v, math.inf, True
        while v + dv <= 0.0:
            dt, dv = 0.5 * dt, 0.5 * dv
        t, v = t + dt, v + dv
        if math.hypot(dt, dv / scale) < 1e-15:
            return t, v, residual, True
    return t, v, residual, False


def newton_orbit(
    oscillator: Oscillator, t: float, v: float, period: int, scale: float, pause: Pause
) -> tuple[float, float, float]:
    """Newton's method from one seed, whatever its period: phase, speed and residual."""
    ended, rounds = False, NEWTON_ROUNDS
    while rounds > 0 and not ended:
        pause()
        now = min(rounds, max(1, _IMPACTS_A_LEG // period))
        t, v, residual, ended = newton_rounds(oscillator, t, v, period, scale, now)
        rounds -= now
    return float(wrap_all(np.array([t]))[0]), v, residual


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
        None if Newton's method does not reach a residual of at most 1e-11, or ends at rest on the wall.
    """
    t, v, residual = newton_orbit(oscillator, t, v, period, scale, pause)
    if not residual <= _RESIDUAL:
        return None
    period = _own_period(oscillator, t, v, period, scale)
    times, speeds = np.empty(period), np.empty(period)
    steps, jacobians = np.empty((period, 2, 2)), np.empty((period, 2, 2))
    elapsed, lower = _orbit_points(oscillator, t, v, period, times, speeds, steps, jacobians)
    if round(elapsed) < 1:
        return None  # the limit v -> 0, where every phase maps to itself, is not an orbit
    first = int(np.argmin(speeds))
    return PeriodicOrbit(
        np.roll(times, -first), np.roll(speeds, -first), round(elapsed), period, int(lower),
        np.roll(jacobians, -first, axis=0), float(residual),
    )  # fmt: skip


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
def _returns_after(oscillator, t, v, divisor, scale):
    t1, v1, _, _, _ = _iterate(oscillator, t, v, divisor)
    f = part_turn(t1 - t)
    return math.hypot(f, (v1 - v) / scale)


def _own_period(oscillator: Oscillator, t: float, v: float, period: int, scale: float) -> int:
    for divisor in range(1, period // 2 + 1):
        if period % divisor == 0 and _returns_after(oscillator, t, v, divisor, scale) < 1e-9:
            return divisor
    return period
