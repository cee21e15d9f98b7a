"""Discs around attracting periodic orbits, with proof: all that depart inside end in the orbit.

Lengths are those of the orbit's eigenframe F: |F x|. The disc is covered by parts. If P^p maps each into the disc, and
DP^p has a norm below 1 over each, then it brings points closer together, for the disc is convex. So the disc holds
exactly one periodic point, to which all others come (Banach). A disc is narrower than a period: then it meets none of
its copies a whole number of periods away, and all of its image lies in the same one.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import Attractor
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import inlined_as_written, kernel_as_written
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit, find_periodic_orbit
from rattle_proof.enclosures.flight import Box, Matrix, halves_of_part, spread
from rattle_proof.enclosures.impact import product
from rattle_proof.enclosures.interval import (
    Interval,
    add,
    divide,
    down,
    middle,
    multiply,
    point,
    root,
    scale,
    square,
    subtract,
    up,
)
from rattle_proof.enclosures.machine import Machine
from rattle_proof.enclosures.moving_set import advance, set_out

_LARGEST, _SMALLEST, _SHRINK = 0.3, 1e-8, 0.85
# Half the width in time of a disc, in periods: it does not meet itself.
_WIDEST = 0.5
_LONGEST = 64
# How often a part of a disc is halved, and how many are followed by one impact each, before the proof is given up.
_DEPTH, _MOST_PARTS = 16, 65536


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
def spectral_norm(a):
    """Bound on the spectral norm: the larger singular value."""
    squares = add(add(square(a.tt), square(a.tv)), add(square(a.vt), square(a.vv)))
    determinant = subtract(multiply(a.tt, a.vv), multiply(a.tv, a.vt))
    gap = root(subtract(square(squares), scale(square(determinant), 4.0)))
    return root(scale(add(squares, gap), 0.5)).high


@inlined_as_written
def _after(machine, oscillator, impacts, box):
    """A box after some impacts; whether it is proven and has not met the grazing curve."""
    moving = set_out(box, False)
    for _ in range(impacts):
        proven, moving = advance(machine, oscillator, moving)
        if not proven or moving.grazed:
            return False, moving
    return True, moving


@inlined_as_written
def lies_in_disc(disc, moving):
    """Whether a set lies within a disc, a row of `disc_rows`."""
    frame = Matrix(point(disc[3]), point(disc[4]), point(disc[5]), point(disc[6]))
    off_t, off_v = subtract(point(moving.t), point(disc[1])), subtract(point(moving.v), point(disc[2]))
    off_t = subtract(off_t, point(math.floor(middle(off_t) + 0.5)))
    moved = spread(product(frame, moving.slope), moving.dt, moving.dv)
    rest = spread(frame, add(off_t, moving.rest.t), add(off_v, moving.rest.w))
    return add(square(add(moved.t, rest.t)), square(add(moved.w, rest.w))).high < disc[7]


@inlined_as_written
def _comes_nearer(machine, oscillator, impacts, disc, box, linear, inverse):
    """Whether all departures of a part of a disc come back into it, nearer to each other."""
    proven, moving = _after(machine, oscillator, impacts, box)
    if not (proven and lies_in_disc(disc, moving)):
        return False
    return spectral_norm(product(product(linear, moving.slope), inverse)) < 1.0


@kernel_as_written
def maps_into_itself(machine, oscillator, impacts, disc):
    """Whether all departures of a disc, a row of `disc_rows`, are proven to come back into it nearer to each other.

    Parameters
    ----------
    machine : Machine
    oscillator : Oscillator
        One of them: where roots are sought first. Nothing rests on it.
    impacts : int
        After how many they come back.
    disc : ndarray, shape (8,)

    Returns
    -------
    bool
    """
    frame = np.array([[disc[3], disc[4]], [disc[5], disc[6]]])
    dt, dv, inverse = _extent(frame, up(math.sqrt(disc[7])))
    if not dt < _WIDEST:
        return False
    linear = Matrix(point(disc[3]), point(disc[4]), point(disc[5]), point(disc[6]))
    stack = np.empty((_DEPTH + 2, 5))
    stack[0] = down(disc[1] - dt), up(disc[1] + dt), down(disc[2] - dv), up(disc[2] + dv), 0.0
    waiting, left = 1, _MOST_PARTS // impacts
    while waiting > 0:
        waiting -= 1
        part = stack[waiting, 0], stack[waiting, 1], stack[waiting, 2], stack[waiting, 3], stack[waiting, 4]
        box = Box(Interval(part[0], part[1]), Interval(part[2], part[3]))
        off = spread(linear, subtract(box.t, point(disc[1])), subtract(box.w, point(disc[2])))
        if add(square(off.t), square(off.w)).low > disc[7]:
            continue  # beside the disc
        left -= 1
        if _comes_nearer(machine, oscillator, impacts, disc, box, linear, inverse):
            continue
        if part[4] >= _DEPTH or left < 0:
            return False
        stack[waiting], stack[waiting + 1] = halves_of_part(part)
        waiting += 2
    return True


def disc_rows(discs: dict[int, OrbitDisc]) -> np.ndarray:
    """Discs as kernels have them.

    Parameters
    ----------
    discs : dict of int to OrbitDisc
        By the number of the motion.

    Returns
    -------
    ndarray, shape (discs, 8)
        In each row its end, time, speed, the four numbers of its frame row by row, and the square of its radius.
    """
    rows = [[1.0 + n, d.t, d.v, *d.frame.ravel(), down(d.radius * d.radius)] for n, d in discs.items()]
    return np.array(rows).reshape(-1, 8)


def eigenframe(orbit: PeriodicOrbit, place: int, speed: float) -> np.ndarray:
    """Rows in which DP^p at a departure of the orbit is a rotation that shrinks, or diagonal.

    Parameters
    ----------
    orbit : PeriodicOrbit
    place : int
        Of the departure.
    speed : float
        That counts as much as a period.

    Returns
    -------
    ndarray, shape (2, 2)
    """
    values, vectors = np.linalg.eig(orbit.jacobians[place])
    rows = np.linalg.inv(vectors)
    if values[0].imag != 0.0:
        rows = np.array([rows[0].real, rows[0].imag])
    scaled = np.linalg.norm(rows * [1.0, speed], axis=1, keepdims=True)
    return np.ascontiguousarray(rows.real / (scaled.max() if values[0].imag != 0.0 else scaled))


def _largest_radius(machine: Machine, oscillator: Oscillator, disc: OrbitDisc, pause: Pause) -> float:
    radius = _LARGEST
    while radius > _SMALLEST:
        pause()
        row = disc_rows({0: disc._replace(radius=radius)})[0]
        if maps_into_itself(machine, oscillator, disc.impacts, row):
            return radius
        radius *= _SHRINK
    return 0.0


def orbit_disc(
    machine: Machine, oscillator: Oscillator, attractor: Attractor, pause: Pause = never_stopped
) -> OrbitDisc | None:
    """Largest disc found around a departure of an attracting periodic orbit.

    Parameters
    ----------
    machine : Machine
    oscillator : Oscillator
        One of them, whose orbit it is.
    attractor : Attractor
        Periodic.
    pause : callable
        Called before each disc is tried; an exception raised there ends the search.

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
        frame = eigenframe(orbit, place, speed)
        disc = OrbitDisc(orbit.upper_contacts, float(orbit.t[place]), float(orbit.v[place]), frame, 0.0)
        disc = disc._replace(radius=_largest_radius(machine, oscillator, disc, pause))
        if best is None or disc.radius > best.radius:
            best = disc
    return best if best is not None and best.radius > 0.0 else None
