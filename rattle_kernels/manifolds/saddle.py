"""Saddles: periodic orbits of P with one multiplier inside the unit circle and one outside.

A periodic orbit of impact period p has a stable and an unstable manifold where the multipliers of DP^p are real, one of
modulus below 1 and one above. By the damping their product, ``e^{-delta m}`` over m forcing periods, is below 1: so no
orbit repels, and one that is no saddle is a node or a focus, or at a bifurcation.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator, check_domain
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit, find_periodic_orbit

# Closer to the unit circle a multiplier says nothing: a saddle-node's orbit is known to the root of rounding.
_MARGIN = 1e-6


class NotASaddle(ValueError):
    """There is no saddle where one was looked for; the message tells what is there, and what would be right."""


class Directions(NamedTuple):
    """Invariant directions at one point of a saddle.

    ``stable`` and ``unstable`` are vectors (dt, dv), of length 1 in the plane (t, v/velocity_scale), towards later
    phases (towards higher speeds, where the phase does not change); ``stable_multiplier`` and ``unstable_multiplier``
    are those of DP^p.
    """

    stable: np.ndarray
    unstable: np.ndarray
    stable_multiplier: float
    unstable_multiplier: float


def orbit_name(orbit: PeriodicOrbit) -> str:
    """``P(m, n+, n-)`` of an orbit."""
    return f"P({orbit.forcing_periods},{orbit.upper_contacts},{orbit.lower_contacts})"


def check_saddle(orbit: PeriodicOrbit) -> PeriodicOrbit:
    """Return the orbit, or say why it is no saddle.

    Raises
    ------
    NotASaddle
    """
    inner, outer = sorted(orbit.multipliers, key=abs)
    where = f"{orbit_name(orbit)} at t = {orbit.t[0]:.6f}, v = {orbit.v[0]:.6f}"
    remedy = (
        "start from a seed nearer to a saddle: one lies on the boundary of each basin that a saddle-node has opened"
    )
    if abs(outer.imag) > 0.0:
        raise NotASaddle(
            f"{where} is a focus: its multipliers are complex, of modulus {abs(outer):.6g}, and it has no manifolds of "
            f"one dimension; {remedy}"
        )
    if abs(abs(outer) - 1.0) < _MARGIN:
        raise NotASaddle(
            f"{where} is at a bifurcation: its multipliers are {inner.real:.6g} and {outer.real:.6g}; a saddle needs "
            "one well outside the unit circle: change a parameter a little"
        )
    if abs(outer) < 1.0:
        raise NotASaddle(
            f"{where} is a node: its multipliers, {inner.real:.6g} and {outer.real:.6g}, both lie inside the unit "
            f"circle; {remedy}"
        )
    return orbit


def is_saddle(orbit: PeriodicOrbit) -> bool:
    """Whether `check_saddle` accepts the orbit."""
    try:
        check_saddle(orbit)
    except NotASaddle:
        return False
    return True


def find_saddle(oscillator: Oscillator, t: float, v: float, period: int = 1) -> PeriodicOrbit:
    """Saddle near a seed, by Newton's method on P^p.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    t, v : float
        Seed: phase and speed of a departure from +beta.
    period : int
        Impact period p, at least 1: n+ of P(m, n+, n-).

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain of the map.
    NotASaddle
        Where there is no periodic orbit, or another than a saddle.
    ValueError
        Where the seed is no departure, or the period is below 1.
    """
    checked = check_domain(oscillator)
    if not (math.isfinite(t) and math.isfinite(v) and v > 0.0):
        raise ValueError(f"a seed must be finite with a positive speed, not t = {t}, v = {v}")
    if period < 1:
        raise ValueError(f"period must be at least 1, the number of impacts with +beta in one turn, not {period}")
    orbit = find_periodic_orbit(checked, float(t), float(v), period, largest_grazing_speed(checked))
    if orbit is None:
        raise NotASaddle(
            f"Newton's method on P^{period} found no periodic orbit from t = {t:.6g}, v = {v:.6g}: start closer to "
            "one, or from an orbit followed here from other parameters"
        )
    return check_saddle(orbit)


def directions(orbit: PeriodicOrbit, at: int, velocity_scale: float) -> Directions:
    """Invariant directions at one point of a saddle.

    Parameters
    ----------
    orbit : PeriodicOrbit
        A saddle.
    at : int
        Which of its points.
    velocity_scale : float
        Speed that counts as much as one forcing period.

    Returns
    -------
    Directions
    """
    scaling = np.array([1.0, velocity_scale])
    multipliers, vectors = np.linalg.eig(orbit.jacobians[at] * scaling / scaling[:, None])
    inner, outer = np.argsort(np.abs(multipliers))
    pointed = [vector if tuple(vector) > (0.0, 0.0) else -vector for vector in vectors.real.T]
    return Directions(
        pointed[inner] * scaling, pointed[outer] * scaling,
        float(multipliers[inner].real), float(multipliers[outer].real),
    )  # fmt: skip
