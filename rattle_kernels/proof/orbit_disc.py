"""Discs around attracting periodic orbits, with proof: all that depart inside end in the orbit.

Lengths are those of the orbit's eigenframe F: |F x|. Over the disc, DP^p has a norm of at most q, and P^p moves the
disc's centre by at most d. If ``q radius + d < radius``, P^p maps the disc into itself and brings points closer
together. So it holds exactly one periodic point, to which all others come (Banach).
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import Attractor
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.interval import (
    add,
    around,
    divide,
    multiply,
    point,
    root,
    scale,
    square,
    subtract,
    up,
)
from rattle_kernels.numerics.jit import inlined_as_written, kernel_as_written
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit, find_periodic_orbit
from rattle_kernels.proof.flight import Box, Matrix
from rattle_kernels.proof.impact import product
from rattle_kernels.proof.machine import Machine
from rattle_kernels.proof.moving_set import advance, set_out

_LARGEST, _SMALLEST, _SHRINK = 0.3, 1e-8, 0.85
_LONGEST = 64


class OrbitDisc(NamedTuple):
    """Departures x with ``|frame (x - (t, v))| < radius``: all end in the orbit that returns after `impacts`."""

    impacts: int
    t: float
    v: float
    frame: np.ndarray
    radius: float

    @property
    def half_sides(self) -> tuple[float, float]:
        """Half the sides of the box around it, in time and speed."""
        dt, dv, _ = _extent(self.frame, self.radius)
        return dt, dv


@inlined_as_written
def _extent(frame, radius):
    """Half the sides of the box around a disc, and the inverse of the frame."""
    a, b, c, d = point(frame[0, 0]), point(frame[0, 1]), point(frame[1, 0]), point(frame[1, 1])
    size = subtract(multiply(a, d), multiply(b, c))
    inverse = Matrix(divide(d, size), divide(scale(b, -1.0), size), divide(scale(c, -1.0), size), divide(a, size))
    dt = up(radius * root(add(square(inverse.tt), square(inverse.tv))).high)
    dv = up(radius * root(add(square(inverse.vt), square(inverse.vv))).high)
    return dt, dv, inverse


@inlined_as_written
def _norm(a):
    """Bound on the spectral norm: the larger singular value."""
    squares = add(add(square(a.tt), square(a.tv)), add(square(a.vt), square(a.vv)))
    determinant = subtract(multiply(a.tt, a.vv), multiply(a.tv, a.vt))
    gap = root(subtract(square(squares), scale(square(determinant), 4.0)))
    return root(scale(add(squares, gap), 0.5)).high


@kernel_as_written
def _maps_into_itself(machine, oscillator, impacts, t, v, frame, radius):
    dt, dv, inverse = _extent(frame, radius)
    moving = set_out(Box(around(t, dt), around(v, dv)), False)
    for _ in range(impacts):
        proven, moving = advance(machine, oscillator, moving)
        if not proven or moving.grazed:
            return False
    linear = Matrix(point(frame[0, 0]), point(frame[0, 1]), point(frame[1, 0]), point(frame[1, 1]))
    nearer = _norm(product(product(linear, moving.slope), inverse))
    off_t = add(subtract(point(moving.t), point(t)), moving.rest.t)
    turns = math.floor(moving.t - t + 0.5)
    off_t = subtract(off_t, point(turns))
    off_v = add(subtract(point(moving.v), point(v)), moving.rest.w)
    x = add(multiply(linear.tt, off_t), multiply(linear.tv, off_v))
    y = add(multiply(linear.vt, off_t), multiply(linear.vv, off_v))
    moves = root(add(square(x), square(y))).high
    return up(up(nearer * radius) + moves) < radius


def _eigenframe(orbit: PeriodicOrbit, place: int, speed: float) -> np.ndarray:
    """Rows in which DP^p at a departure of the orbit is a rotation that shrinks, or diagonal."""
    values, vectors = np.linalg.eig(orbit.jacobians[place])
    rows = np.linalg.inv(vectors)
    if values[0].imag != 0.0:
        rows = np.array([rows[0].real, rows[0].imag])
    scaled = np.linalg.norm(rows * [1.0, speed], axis=1, keepdims=True)
    return np.ascontiguousarray(rows.real / (scaled.max() if values[0].imag != 0.0 else scaled))


def _largest_radius(machine: Machine, oscillator: Oscillator, orbit: PeriodicOrbit, disc: OrbitDisc) -> float:
    radius = _LARGEST
    while radius > _SMALLEST:
        if _maps_into_itself(machine, oscillator, orbit.upper_contacts, disc.t, disc.v, disc.frame, radius):
            return radius
        radius *= _SHRINK
    return 0.0


def orbit_disc(machine: Machine, oscillator: Oscillator, attractor: Attractor) -> OrbitDisc | None:
    """Largest disc found around a departure of an attracting periodic orbit.

    Parameters
    ----------
    machine : Machine
    oscillator : Oscillator
        One of them, whose orbit it is.
    attractor : Attractor
        Periodic.

    Returns
    -------
    OrbitDisc or None
        None where no disc of a radius of 1e-8 or more is proven.
    """
    if attractor.upper_contacts > _LONGEST:
        return None
    speed = largest_grazing_speed(oscillator)
    start = float(attractor.time[0]), float(attractor.velocity[0])
    orbit = find_periodic_orbit(oscillator, *start, attractor.upper_contacts, speed)
    if orbit is None:
        return None
    best = None
    for place in range(orbit.upper_contacts):
        frame = _eigenframe(orbit, place, speed)
        disc = OrbitDisc(orbit.upper_contacts, float(orbit.t[place]), float(orbit.v[place]), frame, 0.0)
        disc = disc._replace(radius=_largest_radius(machine, oscillator, orbit, disc))
        if best is None or disc.radius > best.radius:
            best = disc
    return best if best is not None and best.radius > 0.0 else None
