"""Traps: neighbourhoods of attracting periodic orbits, for damping so weak that convergence takes too long.

A turn around a periodic orbit brings a trajectory closer only by e^{-delta m/2}, where m is the number of forcing
periods in a turn. At a damping of 6e-4, convergence takes some 10^5 periods. But once a trajectory is inside a
neighbourhood that P^p maps into itself, its phase on the orbit is known for good, and with it every later image.

If the multipliers are complex, P^p rotates its eigencoordinate z and contracts |z|. Further out nonlinear terms deform
circles by far more than one turn contracts them. So levels of a polynomial replace circles:

    V = |z|^2 + sum c_jk z^j conj(z)^k,   3 <= j + k <= 8, j > k,

It is fitted to ``V(P^p z) = D V(z)``, where D is the determinant of DP^p: e^{-delta m}, and less where impacts or
contacts lose energy, too. That is linear in c (Birkhoff's normal form, by least squares). The levels follow the
invariant curves of the undamped map through most of the island.

A fit alone shows nothing. The trap is the region V < level within a disc |z| <= radius that passes three tests:

1. The outer circle stays on the orbit's side of the grazing curve at every impact of a turn, with a margin from node to
   node. P maps the disc inside the circle to the disc inside its image, so no flight from inside grazes.
2. The descent ``(change of ln V)/(-ln D)``, -1 at the centre, is at most -1/2 at all nodes of a polar mesh and
   differs by less than 1/4 between neighbours.
3. V is above the level on the outer circle. The image of the trap is connected and contains the centre, so it cannot
   leave the disc.

Hence every turn multiplies V by sqrt(D) at most.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.chatter import descends_everywhere
from rattle_kernels.lanes.run import next_impacts
from rattle_kernels.lanes.traps import DEGREE, POWERS
from rattle_kernels.model.grazing_curve import grazing_speeds
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.numerics.phase import wrap_all
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit

_LARGEST, _SMALLEST, _SHRINK = 0.2, 1e-6, 0.5
# Once a trap is found, radii between it and the last failure are tried, the largest first.
_STRETCHES = (1.7, 1.4, 1.2)
_FIT_RADII, _FIT_ANGLES = 12, 48
_TEST_RADII, _TEST_ANGLES = 16, 64


class Trap(NamedTuple):
    """Region around the slowest point of an orbit: |z| <= radius, V < level; z = frame (dt, dv), V >= floor |z|^2.

    `rate` is -ln D, by which a turn lowers ln V at the centre.
    """

    orbit: PeriodicOrbit
    frame: np.ndarray
    radius: float
    level: float
    floor: float
    coefficients: np.ndarray
    rate: float


def _lost_in_a_turn(oscillator: Oscillator, orbit: PeriodicOrbit) -> float:
    """-ln D: delta m exactly, unless contacts lose energy, too."""
    if oscillator.restitution == 1.0 and oscillator.contact_damping == 0.0:
        return oscillator.damping * orbit.forcing_periods
    return -math.log(np.linalg.det(orbit.jacobians[0]))


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
        speeds = grazing_speeds(oscillator)[::2]
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
            above = side * (v - np.interp(wrap_all(t), *self.grazes))
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
    return Trap(turn.orbit, turn.frame, radius, level, floor, fitted, rate) if level > 0.0 else None


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
    rate = _lost_in_a_turn(oscillator, orbit)
    radius = _LARGEST
    while radius > _SMALLEST:
        pause()
        trap = _trap_within(turn, radius, rate)
        if trap is not None:
            larger = (_trap_within(turn, stretch * radius, rate) for stretch in _STRETCHES)
            return next((each for each in larger if each is not None), trap)
        radius *= _SHRINK
    return None
