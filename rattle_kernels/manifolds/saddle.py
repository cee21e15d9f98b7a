"""Saddles: periodic orbits of P with one multiplier inside the unit circle and one outside.

A periodic orbit of impact period p has a stable and an unstable manifold if the multipliers of DP^p are real, one of
modulus below 1 and one above. Damping makes their product, ``e^{-delta m}`` over m forcing periods, less than 1. So no
orbit repels, and an orbit that is not a saddle is a node, a focus or at a bifurcation.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit, find_periodic_orbit

# Closer to the unit circle a multiplier decides nothing: at a saddle-node the orbit's error is the root of rounding.
_MARGIN = 1e-6


class NotASaddle(ValueError):
    """There is no saddle where one was expected. The message says what is there, and what to try instead."""


class Directions(NamedTuple):
    """Invariant directions at one point of a saddle.

    ``stable`` and ``unstable`` are vectors (dt, dv) of length 1 in the plane (t, v/velocity_scale). They point towards
    later phases, or towards higher speeds if the phase does not change. ``stable_multiplier`` and
    ``unstable_multiplier`` are the eigenvalues of DP^p.
    """

    stable: np.ndarray
    unstable: np.ndarray
    stable_multiplier: float
    unstable_multiplier: float


def check_saddle(orbit: PeriodicOrbit) -> PeriodicOrbit:
    """Return the orbit, or raise an error that says why it is not a saddle.

    Raises
    ------
    NotASaddle
    """
    inner, outer = sorted(orbit.multipliers, key=abs)
    where = f"{orbit.name} at t = {orbit.t[0]:.6f}, v = {orbit.v[0]:.6f}"
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
        If the oscillator's parameters lie outside the domain of the map.
    NotASaddle
        If there is no periodic orbit, or it is not a saddle.
    ValueError
        If the seed is not a departure, or the period is below 1.
    """
    checked = check_oscillator(oscillator)
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
        Index of the point.
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
