"""Traps: neighbourhoods of attracting periodic orbits, for damping so weak that convergence takes too long.

A turn around a periodic orbit brings a trajectory closer only by e^{-delta m/2}, where m is the number of forcing
periods in a turn. At a damping of 6e-4, convergence takes some 10^5 periods. But once a trajectory is inside a
neighbourhood that P^p maps into itself, its phase on the orbit is known for good, and with it every later image.

If the multipliers are complex, P^p rotates its eigencoordinate z and contracts |z|. Further out nonlinear terms deform
circles by far more than one turn contracts them. So levels of a polynomial replace circles:

    V = |z|^2 + sum c_jk z^j conj(z)^k,   3 <= j + k <= 8, j > k,

It is fitted to ``V(P^p z) = e^{-delta m} V(z)``, which is linear in c (Birkhoff's normal form, by least squares). The
levels follow the invariant curves of the undamped map through most of the island.

A fit proves nothing. The trap is the region V < level within a disc |z| <= radius that passes three tests:

1. The outer circle stays on the orbit's side of the grazing curve at every impact of a turn, with a margin from node to
   node. P maps the disc inside the circle to the disc inside its image, so no flight from inside grazes.
2. The descent ``(change of ln V)/(delta m)``, -1 at the centre, is at most -1/2 at all nodes of a polar mesh and
   differs by less than 1/4 between neighbours.
3. V is above the level on the outer circle. The image of the trap is connected and contains the centre, so it cannot
   leave the disc.

Hence every turn multiplies V by e^{-delta m/2} at most.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import Attractor, AttractorKind
from rattle_kernels.impact_map.chatter import REQUIRED_DESCENT, descends_everywhere
from rattle_kernels.lanes.run import next_impacts
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.lanes.traps import DEGREE, NO_TRAPS, NOWHERE, POWERS, LaneTraps
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.pausing import Pause, Stoppable, never_stopped
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit, derivatives_along, find_periodic_orbit

_LARGEST, _SMALLEST, _SHRINK = 0.2, 1e-6, 0.5
# Once a trap is found, radii between it and the last failure are tried, the largest first.
_STRETCHES = (1.7, 1.4, 1.2)
_FIT_RADII, _FIT_ANGLES = 12, 48
_TEST_RADII, _TEST_ANGLES = 16, 64
_LONGEST_PERIOD = 512
_ROWS, _COLUMNS = 1024, 512
# Distance from an orbit's point up to which the lattice points to it, in radii of its trap.
_REACH = 2.0


class Trap(NamedTuple):
    """Region around the slowest point of an orbit: |z| <= radius, V < level; z = frame (dt, dv), V >= floor |z|^2."""

    orbit: PeriodicOrbit
    frame: np.ndarray
    radius: float
    level: float
    floor: float
    coefficients: np.ndarray


def _eigenframe(orbit: PeriodicOrbit, scale: float) -> np.ndarray | None:
    """Real and imaginary part of the eigencoordinate of DP^p as rows; None if the multipliers are real."""
    values, vectors = np.linalg.eig(orbit.jacobians[0])
    if values[0].imag == 0.0:
        return None
    row = np.linalg.inv(vectors)[0]
    row = row / np.linalg.norm(row * [1.0, scale])
    return np.array([row.real, row.imag])


def _monomials(z: np.ndarray) -> np.ndarray:
    powers = np.cumprod(np.vstack([np.ones_like(z), np.broadcast_to(z, (DEGREE, z.size))]), axis=0)
    terms = [powers[j] * powers[k].conj() for j, k in POWERS]
    return np.array([part for term in terms for part in (term.real, -term.imag)]).T


class _Turn:
    """Points z around the slowest point of an orbit, and their images after a turn."""

    def __init__(self, oscillator: Oscillator, orbit: PeriodicOrbit, frame: np.ndarray) -> None:
        self.oscillator, self.orbit, self.frame = oscillator, orbit, frame
        self.back = np.linalg.inv(frame)
        speeds = lane_tables(oscillator).graze_speed
        self.grazes = np.linspace(0.0, 1.0, speeds.size), speeds

    def departures(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        dt, dv = self.back @ np.array([z.real, z.imag])
        return self.orbit.t[0] + dt, self.orbit.v[0] + dv

    def after(self, z: np.ndarray) -> np.ndarray | None:
        """Points after a turn; None if one does not follow the orbit."""
        t, v = self.departures(z)
        if not v.min() > 0.0:
            return None
        landed = next_impacts(self.oscillator, t, v, self.orbit.upper_contacts)
        if not (landed.lower_impacts == self.orbit.lower_contacts).all() or not np.isfinite(landed.t).all():
            return None
        dt = landed.t - self.orbit.t[0]
        x, y = self.frame @ np.array([dt - np.rint(dt), landed.v - self.orbit.v[0]])
        return x + 1j * y

    def keeps_clear_of_grazing(self, ring: np.ndarray) -> bool:
        """Whether a closed curve stays on the orbit's side of the grazing curve at every impact of a turn."""
        t, v = self.departures(ring)
        if not v.min() > 0.0:
            return False
        for here, speed in zip(self.orbit.t, self.orbit.v, strict=True):
            side = np.sign(speed - np.interp(here, *self.grazes))
            above = side * (v - np.interp(t % 1.0, *self.grazes))
            if not above.min() > np.abs(np.diff(above, append=above[:1])).max():
                return False
            t, v, _, _ = next_impacts(self.oscillator, t, v)
            if not np.isfinite(t).all():
                return False
        return True


def _polar(radii: np.ndarray, angles: int) -> np.ndarray:
    return radii[:, None] * np.exp(2j * np.pi * np.arange(angles) / angles)


def _fit(turn: _Turn, radius: float, shrinks: float) -> np.ndarray | None:
    nodes = 0.5 - 0.5 * np.cos(np.pi * (np.arange(_FIT_RADII) + 0.5) / _FIT_RADII)
    z = _polar(radius * nodes, _FIT_ANGLES).ravel()
    later = turn.after(z)
    if later is None:
        return None
    weight = 1.0 / np.abs(z) ** 2
    system = (_monomials(later) - shrinks * _monomials(z)) * weight[:, None]
    goal = (shrinks * np.abs(z) ** 2 - np.abs(later) ** 2) * weight
    scale = np.linalg.norm(system, axis=0)
    return np.linalg.lstsq(system / scale, goal, rcond=1e-13)[0] / scale


def _descends(before: np.ndarray, after: np.ndarray, rate: float) -> bool:
    """Whether V falls evenly, and at every node of a polar mesh at least half as fast as at the centre."""
    if not (before.min() > 0.0 and after.min() > 0.0):
        return False
    return bool(descends_everywhere(np.log(after / before) / rate))


def _trap_within(turn: _Turn, radius: float, rate: float) -> Trap | None:
    """Trap in a disc; None if it fails a test."""
    z = _polar(radius * (np.arange(_TEST_RADII) + 1) / _TEST_RADII, _TEST_ANGLES)
    edge = turn.after(z[-1])
    if edge is None or np.abs(edge).max() > 2.0 * radius or not turn.keeps_clear_of_grazing(z[-1]):
        return None
    fitted, later = _fit(turn, radius, math.exp(-rate)), turn.after(z.ravel())
    if fitted is None or later is None:
        return None
    before, after = (
        (np.abs(points) ** 2 + _monomials(points) @ fitted).reshape(z.shape) for points in (z.ravel(), later)
    )
    if not _descends(before, after, rate):
        return None
    edge = before[-1]
    level = float(edge.min() - np.abs(np.diff(edge, append=edge[:1])).max())
    floor = float(0.5 * (before / np.abs(z) ** 2).min())
    return Trap(turn.orbit, turn.frame, radius, level, floor, fitted) if level > 0.0 else None


def find_trap(oscillator: Oscillator, orbit: PeriodicOrbit, scale: float, pause: Pause = never_stopped) -> Trap | None:
    """Largest trap found around an orbit.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    orbit : PeriodicOrbit
        An attracting orbit.
    scale : float
        Speed that counts as much as one forcing period.
    pause : callable
        Called several times a second; an exception raised there ends the search.

    Returns
    -------
    Trap or None
        None if the multipliers are real, or no disc with a radius above 1e-6 passes the tests.
    """
    frame = _eigenframe(orbit, scale)
    if frame is None or not orbit.attracts:
        return None
    turn = _Turn(oscillator, orbit, frame)
    rate = oscillator.damping * orbit.forcing_periods
    radius = _LARGEST
    while radius > _SMALLEST:
        pause()
        trap = _trap_within(turn, radius, rate)
        if trap is not None:
            larger = (_trap_within(turn, stretch * radius, rate) for stretch in _STRETCHES)
            return next((each for each in larger if each is not None), trap)
        radius *= _SHRINK
    return None


def _along(oscillator: Oscillator, trap: Trap, scale: float) -> tuple[np.ndarray, np.ndarray]:
    """For each point of a trap's orbit, the frame that gives z on arrival at the slowest point, and the stretch."""
    orbit = trap.orbit
    derivatives = derivatives_along(oscillator, orbit)
    arriving, leaving = [], [np.linalg.inv(trap.frame)]
    ahead = trap.frame
    for derivative in derivatives[::-1]:
        ahead = ahead @ derivative
        arriving.append(ahead)
    for derivative in derivatives[:-1]:
        leaving.append(derivative @ leaving[-1])
    scaled = np.array(leaving) * np.array([1.0, 1.0 / scale])[:, None]
    return np.array(arriving[::-1]), np.linalg.norm(scaled, ord=2, axis=(1, 2))


@kernel
def _paint(time, speed, frames, radius, top, nearest, closeness):
    """Write the nearest orbit point within reach into each cell of the lattice; distances are in radii of its trap."""
    rows, columns = nearest.shape
    high, wide = top / rows, 1.0 / columns
    for i in range(time.size):
        a, b, c, d = frames[i, 0, 0], frames[i, 0, 1], frames[i, 1, 0], frames[i, 1, 1]
        determinant = abs(a * d - b * c)
        # A cell counts as near if any part of it is.
        size = radius[i] + 0.5 * (wide * math.hypot(a, c) + high * math.hypot(b, d))
        span_t, span_v = _REACH * size * math.hypot(b, d) / determinant, _REACH * size * math.hypot(a, c) / determinant
        first_row = max(int((speed[i] - span_v) / high), 0)
        last_row = min(int((speed[i] + span_v) / high), rows - 1)
        span = min(int(span_t / wide) + 1, columns // 2)
        middle = int(time[i] / wide)
        for row in range(first_row, last_row + 1):
            dv = (row + 0.5) * high - speed[i]
            for column in range(middle - span, middle + span + 1):
                dt = (column + 0.5) * wide - time[i]
                distance = math.hypot(a * dt + b * dv, c * dt + d * dv) / size
                if distance < _REACH and distance < closeness[row, column % columns]:
                    closeness[row, column % columns] = distance
                    nearest[row, column % columns] = i


def _gather(oscillator: Oscillator, traps: Sequence[Trap], scale: float) -> LaneTraps:
    periods = np.array([trap.orbit.upper_contacts for trap in traps])
    first = np.cumsum(periods) - periods
    frames, stretches = zip(*(_along(oscillator, trap, scale) for trap in traps), strict=True)
    time, speed = (np.concatenate([getattr(trap.orbit, name) for trap in traps]) for name in ("t", "v"))
    radius = np.array([trap.radius for trap in traps])
    nearest = np.full((_ROWS, _COLUMNS), NOWHERE, np.int32)
    top = 1.05 * float(speed.max())
    _paint(
        time, speed, np.concatenate(frames), np.repeat(radius, periods), top, nearest, np.full(nearest.shape, np.inf)
    )
    coefficients = np.array([trap.coefficients for trap in traps])
    return LaneTraps(
        nearest, top,
        orbit=np.repeat(np.arange(len(traps)), periods),
        place=np.concatenate([np.arange(period) for period in periods]),
        time=time, speed=speed, stretch=np.concatenate(stretches), first=first, period=periods,
        rate=np.array([-REQUIRED_DESCENT * oscillator.damping * trap.orbit.forcing_periods for trap in traps]),
        frame=np.array([trap.frame.ravel() for trap in traps]),
        radius=radius,
        level=np.array([trap.level for trap in traps]),
        floor=np.array([trap.floor for trap in traps]),
        real=coefficients[:, ::2].copy(), imaginary=coefficients[:, 1::2].copy(),
    )  # fmt: skip


@lru_cache(maxsize=256)
def _trap_of(oscillator: Oscillator, t: float, v: float, period: int, stoppable: Stoppable) -> Trap | None:
    scale = largest_grazing_speed(oscillator)
    orbit = find_periodic_orbit(oscillator, t, v, period, scale)
    return None if orbit is None else find_trap(oscillator, orbit, scale, stoppable.pause)


@lru_cache(maxsize=8)
def _lane_traps(
    oscillator: Oscillator, orbits: tuple[tuple[float, float, int], ...], stoppable: Stoppable
) -> LaneTraps:
    found = [_trap_of(oscillator, *orbit, stoppable) for orbit in orbits]
    traps = [trap for trap in found if trap is not None]
    return _gather(oscillator, traps, largest_grazing_speed(oscillator)) if traps else NO_TRAPS


def build_trap_table(
    oscillator: Oscillator, attractors: Sequence[Attractor], pause: Pause = never_stopped
) -> LaneTraps:
    """Traps of a catalogue's periodic orbits, built once per process.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    attractors : sequence of Attractor
    pause : callable
        Called several times a second; an exception raised there ends the search.

    Returns
    -------
    LaneTraps
        Traps of the orbits around which one was found.
    """
    orbits = tuple(
        (float(each.time[0]), float(each.velocity[0]), each.upper_contacts)
        for each in attractors
        if each.kind == AttractorKind.PERIODIC and each.upper_contacts <= _LONGEST_PERIOD
    )
    return _lane_traps(oscillator, orbits, Stoppable(pause))
