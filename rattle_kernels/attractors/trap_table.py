"""The traps of a catalogue as lanes read them: a lattice over the plane that points to the nearest orbit's trap."""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from rattle_kernels.attractors.attractor import Attractor, AttractorKind
from rattle_kernels.attractors.trapping_region import Trap, find_trap
from rattle_kernels.impact_map.chatter import REQUIRED_DESCENT
from rattle_kernels.lanes.traps import NO_TRAPS, NOWHERE, LaneTraps
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import kernel
from rattle_kernels.numerics.pausing import Pause, Stoppable, never_stopped
from rattle_kernels.orbits.periodic_orbit import derivatives_along, find_periodic_orbit

_LONGEST_PERIOD = 512
_ROWS, _COLUMNS = 1024, 512
# Distance from an orbit's point up to which the lattice points to it, in radii of its trap.
_REACH = 2.0


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
        rate=np.array([-REQUIRED_DESCENT * trap.rate for trap in traps]),
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
