"""Criteria by which a trajectory has arrived at an attractor.

*Periodic orbit*: an ellipse around its slowest point in which P^p contracts. The quadratic form solves the discrete
Lyapunov equation of DP^p. A solution exists because both multipliers lie inside the unit circle. The ellipse shrinks
until P^p itself contracts, in that norm, points on four rings in it. Grazing inside the ellipse would break this, and
so shrinks it. Every other point has an ellipse that P maps into the first one, found in the same way.

*Chaos*, an attractor or a long transient: a lattice of boxes, 2048 to a period and to the largest grazing speed, marked
by a million of its points. A trajectory has arrived when it hits marked boxes of one attractor at 24 impacts in a row.
A trajectory of a neighbouring basin can pass through marked boxes too. But to do so 24 times it must start within about
2048^-1 e^(-24 lambda) of the attractor's own orbits, where lambda is its exponent per impact. So the sets are
distinguished far below the size of any cell.

*Capture* by ever lower bounces: as in `impact_map.chatter`.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import Attractor, AttractorKind
from rattle_kernels.attractors.chaotic_boxes import marked_boxes
from rattle_kernels.lanes.arrival import BOXES, ELLIPSE_COLUMNS, UNMARKED, follow
from rattle_kernels.lanes.run import next_impacts, run_lanes
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import Outcome
from rattle_kernels.numerics.pausing import Pause, Stoppable, never_stopped
from rattle_kernels.orbits.periodic_orbit import PeriodicOrbit, derivatives_along, find_periodic_orbit

_ROUNDS = 200
# After a carry this is enough for a streak. Settled points are recognised at once, others are carried on.
_ROUNDS_AFTER_A_CARRY = 40
# Low bounces near the bound of Eq. (8) are captured after up to 400,000 impacts. Slower than this part of the largest
# grazing speed a point is taken for one of them, and is carried for as many times the legs.
_LOW = 0.01
_LEGS_OF_LOW_BOUNCES = 4
_SHARED_BOX = -2

_LARGEST_ELLIPSE = 0.05
_SMALLEST_ELLIPSE = 1e-9
_DIRECTIONS = 48
_RINGS = (1.0, 0.5, 0.25, 0.125)


class Neighbourhoods(NamedTuple):
    """Regions in which each attractor of a catalogue is recognised.

    ``centre`` (shape (n, 2)) holds phase and speed of the points of periodic orbits, ``form`` (n, 3) the ellipse
    ``form0 dt^2 + 2 form1 dt dv + form2 dv^2 <= 1`` around each, ``owner`` (n,) the index of the attractor. The period
    has ELLIPSE_COLUMNS columns. ``ellipse`` lists, column by column, the ellipses that reach into it, beginning at
    ``first_ellipse``. ``box_owner`` (rows, BOXES) int16 is the index of the chaotic motion that marked a box.
    ``largest_grazing_speed`` spans BOXES rows.
    """

    centre: np.ndarray
    form: np.ndarray
    owner: np.ndarray
    first_ellipse: np.ndarray
    ellipse: np.ndarray
    box_owner: np.ndarray
    largest_grazing_speed: float


def _contracting_form(jacobian: np.ndarray, scale: float) -> tuple[np.ndarray, float]:
    """Quadratic form in (dt, dv/scale) that DP^p contracts, and its factor per turn."""
    scaling = np.diag([1.0, 1.0 / scale])
    scaled = scaling @ jacobian @ np.linalg.inv(scaling)
    factor = 0.5 * (1.0 + np.abs(np.linalg.eigvals(scaled)).max())
    slow = scaled / factor
    form = np.linalg.solve(np.eye(4) - np.kron(slow.T, slow.T), np.eye(2).ravel()).reshape(2, 2)
    return form / np.linalg.eigvalsh(form).min(), factor


def _ring(root: np.ndarray) -> np.ndarray:
    """Points on four ellipses of a form root^T root, the outermost of size 1, as columns."""
    angles = 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    ring = np.linalg.solve(root, np.array([np.cos(angles), np.sin(angles)]))
    return np.concatenate([part * ring for part in _RINGS], axis=1)


def _norms_after(
    oscillator: Oscillator, orbit: PeriodicOrbit, at: int, offsets: np.ndarray, form: np.ndarray, scale: float
) -> np.ndarray | None:
    """Norms of offsets from a point of an orbit after they reach its first point; None if one is not a departure."""
    t, v = orbit.t[at] + offsets[0], orbit.v[at] + offsets[1] * scale
    if not v.min() > 0.0:
        return None
    landed = next_impacts(oscillator, t, v, orbit.upper_contacts - at, shortcuts=oscillator.is_loose)
    apart = landed.t - orbit.t[0]
    offset = np.array([apart - np.rint(apart), (landed.v - orbit.v[0]) / scale])
    return np.sqrt(np.einsum("in,ij,jn->n", offset, form, offset))


def _ellipses_along(oscillator: Oscillator, orbit: PeriodicOrbit, scale: float, pause: Pause) -> list[np.ndarray]:
    """Roots of the forms of ellipses around an orbit's points: P^p contracts the first, P maps the others into it."""
    scaling = np.diag([1.0, 1.0 / scale])
    first, factor = _contracting_form(orbit.jacobians[0], scale)
    bounds = 0.5 * (1.0 + factor) * np.repeat(_RINGS, _DIRECTIONS)
    roots, size = [], _LARGEST_ELLIPSE
    root_of_first = np.linalg.cholesky(first).T
    onward, derivatives = np.eye(2), derivatives_along(oscillator, orbit)
    for at in (0, *range(orbit.upper_contacts - 1, 0, -1)):
        if at > 0:
            # Half the size that the linear map takes to the edge of the first ellipse: room for nonlinear terms.
            onward = onward @ (scaling @ derivatives[at] @ np.linalg.inv(scaling))
        # With strong damping an ellipse would reach far beyond the linear range. This builds the root of the form, not
        # the form, whose eigenvalues differ by sixteen orders of magnitude along orbits of hundreds of impacts.
        reach = 0.0 if at == 0 else size / _LARGEST_ELLIPSE
        root = np.linalg.qr(np.vstack([root_of_first @ onward, reach * np.eye(2)])).R
        rings, here = _ring(root), size if at == 0 else 0.5 * size
        while here > _SMALLEST_ELLIPSE:
            pause()
            norms = _norms_after(oscillator, orbit, at, here * rings, first, scale)
            if norms is not None and (norms <= (here * bounds if at == 0 else size)).all():
                break
            here *= 0.5
        size = here if at == 0 else size
        roots.append(root @ scaling / here)
    return [roots[0], *roots[:0:-1]]


@lru_cache(maxsize=256)
def _ellipses(
    oscillator: Oscillator, times: bytes, speeds: bytes, stoppable: Stoppable
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of a periodic orbit, the forms of their ellipses, and how far these reach in time."""
    scale = largest_grazing_speed(oscillator)
    t, v = np.frombuffer(times), np.frombuffer(speeds)
    orbit = find_periodic_orbit(oscillator, float(t[0]), float(v[0]), t.size, scale)
    if orbit is None:
        raise ValueError(f"the catalogue's orbit at t = {t[0]}, v = {v[0]} is no orbit of {oscillator}")
    roots = np.array(_ellipses_along(oscillator, orbit, scale, stoppable.pause))
    forms = np.einsum("nij,nik->njk", roots, roots)[:, (0, 0, 1), (0, 1, 1)]
    reach = np.hypot(*np.linalg.inv(roots)[:, 0].T)
    return np.column_stack([orbit.t, orbit.v]), forms, reach


@lru_cache(maxsize=4)
def _own_boxes(oscillator: Oscillator, chaotic: tuple[tuple[int, bytes, bytes], ...]) -> np.ndarray:
    """Owner of each box of the lattice, of motions with their points; a box that two of them hit has none."""
    marked = {index: marked_boxes(oscillator, *points) for index, *points in chaotic}
    rows = 1 + max((int(boxes[-1]) // BOXES for boxes in marked.values()), default=0)
    owner = np.full(rows * BOXES, UNMARKED, np.int16)
    for index, boxes in marked.items():
        owner[boxes] = np.where(owner[boxes] == UNMARKED, index, _SHARED_BOX)
    return owner.reshape(rows, BOXES)


def _by_column(phase: np.ndarray, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Start of each column's ellipses in the list, and the list of their numbers, ascending in each column."""
    reach = reach + 1e-12
    lowest = np.floor((phase - reach) * ELLIPSE_COLUMNS).astype(np.int64)
    columns = np.minimum(np.floor((phase + reach) * ELLIPSE_COLUMNS).astype(np.int64) - lowest + 1, ELLIPSE_COLUMNS)
    number = np.repeat(np.arange(phase.size), columns)
    within = np.arange(number.size) - np.repeat(np.cumsum(columns) - columns, columns)
    column = (lowest[number] + within) % ELLIPSE_COLUMNS
    first = np.concatenate([[0], np.cumsum(np.bincount(column, minlength=ELLIPSE_COLUMNS))])
    return first, number[np.argsort(column, kind="stable")]


def neighbourhoods(
    oscillator: Oscillator, attractors: Sequence[Attractor], pause: Pause = never_stopped
) -> Neighbourhoods:
    """Neighbourhoods of a catalogue; those of each attractor are built once per process.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    attractors : sequence of Attractor
        Permanent contact first.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    Neighbourhoods
    """
    ellipses, owner = [(np.empty((0, 2)), np.empty((0, 3)), np.empty(0))], []
    chaotic: list[tuple[int, bytes, bytes]] = []
    for index, attractor in enumerate(attractors):
        if not attractor.time.size:  # permanent contact, or in a sweep an attractor of other basins
            continue
        points = attractor.time.tobytes(), attractor.velocity.tobytes()
        if attractor.is_chaotic:
            chaotic.append((index, *points))
        elif attractor.kind == AttractorKind.PERIODIC:
            ellipses.append(_ellipses(oscillator, *points, Stoppable(pause)))
            owner += [index] * attractor.time.size
    scale = largest_grazing_speed(oscillator)
    centres, forms, reach = (np.concatenate(parts) for parts in zip(*ellipses, strict=True))
    return Neighbourhoods(
        centres, forms, np.array(owner, np.int64), *_by_column(centres[:, 0], reach),
        _own_boxes(oscillator, tuple(chaotic)), scale,
    )  # fmt: skip


def locate(
    oscillator: Oscillator,
    around: Neighbourhoods,
    t: np.ndarray,
    v: np.ndarray,
    legs: int = 0,
    pause: Pause = never_stopped,
) -> np.ndarray:
    """Apply P to points until each has arrived at an attractor.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    around : Neighbourhoods
        Of the catalogue.
    t, v : ndarray of float64, shape (n,)
        Departures from +beta.
    legs : int
        How often a point that has not arrived within 200 impacts, as on a transient, is carried another 4093 and
        checked for 40 more. A point in low bounces is carried four times as often.
    pause : callable
        Called between legs; an exception raised there ends the search.

    Returns
    -------
    ndarray of int64, shape (n,)
        Index of the attractor, -1 if it arrived at none. Each result is independent of the other points.
    """
    tables = lane_tables(oscillator)
    place = np.full(t.size, -1, np.int64)
    left, t, v = np.arange(t.size), t.copy(), v.copy()
    for leg in range(_LEGS_OF_LOW_BOUNCES * legs + 1):
        pause()
        if leg > 0:
            carried, _ = run_lanes(oscillator, t, v, 4093, shortcuts=True)
            place[left[carried.outcome == Outcome.PERMANENT_CONTACT]] = 0
            going = carried.outcome == Outcome.RETURNED
            left, t, v = left[going], carried.t[going], carried.v[going]
        arrived = np.full(left.size, -1, np.int64)
        follow(oscillator, tables, around, _ROUNDS_AFTER_A_CARRY if leg > 0 else _ROUNDS, t, v, arrived)
        place[left] = arrived
        goes_on = (arrived < 0) & ((leg < legs) | (v < _LOW * tables.largest_grazing_speed))
        left, t, v = (field[goes_on] for field in (left, t, v))
        if not left.size:
            break
    return place
