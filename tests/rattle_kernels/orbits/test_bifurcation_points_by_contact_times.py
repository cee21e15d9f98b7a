"""The paper's special points by another way: contact times as unknowns, Eq. (6) as printed, no impact map at all.

Between two contacts at given times the flight of Eq. (6) is fixed by its ends, so an orbit is a list of times at which
velocities reverse: g_k = arriving + leaving velocity = 0 at every contact k. A small change of the times stays an orbit
(multiplier +1: saddle-node) or becomes its own negative after a turn (-1: doubling) where the matrix of dg/dT, closed
periodically or with opposite sign, is singular. Derivatives are exact by complex steps.
"""

import cmath
import math

import numpy as np
import pytest

from rattle_kernels import Oscillator, SpecialKind, continue_orbit, find_orbits, time_history

EPSILON, BETA, TINY = 0.1, 0.6, 1e-30


def end_velocities(begin, end, wall, next_wall, damping):
    """Velocities at both ends of the flight of Eq. (6) between two contacts."""
    decay = cmath.exp(-damping * (end - begin))
    here, there = (
        side * BETA - EPSILON * cmath.cos(2 * math.pi * t) - 4 * math.pi * t
        for side, t in ((wall, begin), (next_wall, end))
    )
    c2 = (there - here) / (decay - 1)
    forced = (4 * math.pi - 2 * math.pi * EPSILON * cmath.sin(2 * math.pi * t) for t in (begin, end))
    return [rate - damping * c2 * part for rate, part in zip(forced, (1.0, decay), strict=True)]


def reversal(before, now, after, walls, damping):
    """Arriving plus leaving velocity at a contact, from the times of it and its neighbours."""
    arriving = end_velocities(before, now, walls[0], walls[1], damping)[1]
    return arriving + end_velocities(now, after, walls[1], walls[2], damping)[0]


def around(times, walls, k, turns):
    """Times and walls of a contact and its neighbours, on from one turn to the next."""
    n = len(times)
    neighbours = [times[j % n] + turns * (j // n) for j in (k - 1, k, k + 1)]
    return neighbours, [walls[j % n] for j in (k - 1, k, k + 1)]


def reversals(times, walls, turns, damping):
    pairs = [around(times, walls, k, turns) for k in range(len(times))]
    return np.array([reversal(*near, sides, damping).real for near, sides in pairs])


def closed_determinant(times, walls, turns, damping, sign):
    """Determinant of dg/dT, with `sign` where a neighbour lies in another turn."""
    n = len(times)
    matrix = np.zeros((n, n))
    for k in range(n):
        near, sides = around(times, walls, k, turns)
        for slot, j in enumerate((k - 1, k, k + 1)):
            moved = [t + (1j * TINY if slot == i else 0) for i, t in enumerate(near)]
            matrix[k, j % n] += reversal(*moved, sides, damping).imag / TINY * (1 if 0 <= j < n else sign)
    return np.linalg.det(matrix)


def newton(function, x):
    for _ in range(12):
        step = 1e-6
        columns = [(function(x + step * axis) - function(x - step * axis)) / (2 * step) for axis in np.eye(x.size)]
        x = x - np.linalg.solve(np.column_stack(columns), function(x))
    return x


def contact_times(point, first_over=False):
    """Times and walls of the contacts of an orbit, from the special point's departures: a guess to start from."""
    speed = point.v[0] * (1 - 1e-9 if first_over else 1)
    history = time_history(point.oscillator, point.t[0], BETA, -speed, periods=point.forcing_periods - 1e-6)
    contacts = history.contacts
    times, walls = np.append(point.t[0], contacts.time), np.append(1.0, np.sign(contacts.wall))
    inside = times < point.t[0] + point.forcing_periods - 1e-4
    return times[inside], walls[inside]


def special(name, damping, kind, bounds=(0.45, 0.7)):
    oscillator = Oscillator(damping=damping)
    (orbit,) = (one.orbit for one in find_orbits(oscillator, cells=24) if one.orbit.name == name and one.orbit.attracts)
    branch = continue_orbit(oscillator, orbit, "damping", bounds)
    (point,) = (one for one in branch.special_points if one.kind == kind)
    return point


@pytest.mark.parametrize(
    ("name", "damping", "bounds", "kind", "sign"),
    [
        ("P(1,2,0)", 0.575, (0.55, 0.7), SpecialKind.SADDLE_NODE, 1.0),
        ("P(2,2,1)", 0.575, (0.55, 0.6), SpecialKind.PERIOD_DOUBLING, -1.0),
        ("P(3,3,2)", 0.527, (0.5, 0.53), SpecialKind.SADDLE_NODE, 1.0),
        ("P(3,3,2)", 0.5, (0.49, 0.51), SpecialKind.PERIOD_DOUBLING, -1.0),
    ],
)
def test_turns_and_doublings(name, damping, bounds, kind, sign):
    point = special(name, damping, kind, bounds)
    times, walls = contact_times(point)
    assert (walls < 0).sum() == point.lower_contacts and (walls > 0).sum() == point.upper_contacts
    turns = point.forcing_periods

    def equations(x):
        return np.append(
            reversals(x[:-1], walls, turns, x[-1]), closed_determinant(x[:-1], walls, turns, x[-1], sign) / scale
        )

    scale = abs(closed_determinant(times, walls, turns, point.value + 0.01, sign))
    found = newton(equations, np.append(times, point.value + 1e-4))
    assert found[-1] == pytest.approx(point.value, abs=1e-10)
    assert found[0] == pytest.approx(times[0], abs=1e-6)


def test_the_graze_of_the_doubled_orbit():
    """One contact more, of the touch at -beta: its velocity is 0 on both sides."""
    point = special("P(4,4,2)", 0.585, SpecialKind.GRAZING)
    times, walls = contact_times(point, first_over=True)
    assert (walls < 0).sum() == point.lower_contacts and walls[1] > 0
    touch = 0.5 * (times[0] + times[1])

    def equations(x):
        arriving = end_velocities(x[0], x[-2], 1.0, -1.0, x[-1])
        leaving = end_velocities(x[-2], x[1], -1.0, 1.0, x[-1])
        orbit = reversals(x[:-2], walls, point.forcing_periods, x[-1])
        return np.append(orbit, [arriving[1].real, leaving[0].real])

    found = newton(equations, np.concatenate([times, [touch, point.value]]))
    assert found[-1] == pytest.approx(point.value, abs=1e-10)
