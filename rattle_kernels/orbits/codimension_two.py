"""Points of codimension two on curves of special points: where one more condition holds, or two curves meet.

On a curve of special points, along which two parameters change, each of these is a zero of a test function:

| point | on curves of | test function |
|---|---|---|
| saddle-node and graze | grazes | trace of N less ``1 + det N`` |
| period doubling and graze | grazes | trace of N plus ``1 + det N`` |
| neutral graze | grazes | ``N_12``: the graze changes from persistence to a fold |
| resonant graze of order p | grazes | ``(N^p)_12/N_12``: the multipliers' angle is k pi/p |
| double graze | grazes | speed of another flight less that which touches |
| cusp | saddle-nodes | how det(1 - DP^p) changes along the multiplier's direction |
| generalised doubling | doublings | the cubic coefficient, whose sign says whether the orbit born there attracts |

N is the derivative of a turn at the touch (`graze_kind`). Between two points of a curve at which a test function has
different signs its zero is found by Brent's method. Each value is taken on the curve itself, corrected by Newton's
method in the plane across the chord. So a point is located from both sides.

A curve of saddle-nodes, doublings or grazes of the impacting model ends where another flight of its orbit grazes: the
map is not smooth there. From its last point the flight that is nearest to grazing is made to pass -beta, and Newton's
method looks for the orbit that also grazes. Where the orbit has become turns of a shorter one, the shorter one's graze
is of codimension two, and its test functions are tried.

``(N^p)_12/N_12`` is ``rho^(p-1) sin(p theta)/sin(theta)`` for multipliers of modulus rho and angle theta, with
cos(theta) = trace/(2 sqrt(det N)).
"""

import math
from collections.abc import Callable, Iterator
from enum import StrEnum
from functools import partial
from typing import NamedTuple

import numpy as np

from rattle_kernels.impact_map.grazing_distance import grazing_distances
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_kernels.numerics.pseudo_arclength import System, solve
from rattle_kernels.orbits.bifurcation_curve import SpecialCurve, smooth_side
from rattle_kernels.orbits.bifurcation_point import SpecialPoint
from rattle_kernels.orbits.closure import (
    Departures,
    OrbitShape,
    closure,
    departures_from,
    grazing_speed_at,
)
from rattle_kernels.orbits.graze_kind import touch_monodromy
from rattle_kernels.orbits.orbit_equations import (
    SpecialKind,
    Unknowns,
    special_system,
    together,
    unknowns,
    with_differences,
)

HIGHEST_ORDER = 6
"""Resonant grazes are looked for up to this order."""

# Brent's method ends where the bracket is so short a part of the chord.
_SHORTEST = 1e-14
_MOST_ITERATIONS = 100
# Sixth-order differences along a multiplier's direction: at the first step, in scaled unknowns, truncation and rounding
# are both some 1e-10 of a second derivative. Steps are halved until the value has settled to that part.
_STEP, _MOST_HALVINGS, _SETTLED = 5e-3, 14, 1e-5
_FIRST = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0
_SECOND = np.array([2.0, -27.0, 270.0, -490.0, 270.0, -27.0, 2.0]) / 180.0
# What lies so near to the end of a curve, in scaled unknowns, is why it ends.
_NEAR_END = 1e-3


class CodimensionTwo(StrEnum):
    """Kinds of points of codimension two."""

    CUSP = "cusp"
    GENERALISED_DOUBLING = "generalised period doubling"
    SADDLE_NODE_GRAZE = "saddle-node and graze"
    DOUBLING_GRAZE = "period doubling and graze"
    NEUTRAL_GRAZE = "neutral graze"
    RESONANT_GRAZE = "resonant graze"
    DOUBLE_GRAZE = "double graze"


_MEETS_A_GRAZE = {
    SpecialKind.GRAZING: CodimensionTwo.DOUBLE_GRAZE,
    SpecialKind.SADDLE_NODE: CodimensionTwo.SADDLE_NODE_GRAZE,
    SpecialKind.PERIOD_DOUBLING: CodimensionTwo.DOUBLING_GRAZE,
}


class CodimensionTwoPoint(NamedTuple):
    """A located point of codimension two.

    Parameters
    ----------
    kind : CodimensionTwo
    order, turns : int
        Of a resonant graze: its multipliers have the angle ``pi turns/order``. Else 1 and 0.
    parameters : (str, str)
    values : (float, float)
        Their values.
    oscillator : Oscillator
        With these.
    forcing_periods, upper_contacts, lower_contacts : int
        Of the orbit; a flight that touches is not counted.
    t, v : ndarray, shape (upper_contacts,)
        Its departures, first the one that grazes, if one does.
    multipliers : ndarray of complex, shape (2,)
        Of the orbit on the side where the flight that touches misses.
    residual : float
        Of the equations of the curve, in scaled unknowns.
    error : float
        How far the point may be off along its curve, in scaled unknowns: the length of the bracket, and what is left of
        the test function over its slope.
    """

    kind: CodimensionTwo
    order: int
    turns: int
    parameters: tuple[str, str]
    values: tuple[float, float]
    oscillator: Oscillator
    forcing_periods: int
    upper_contacts: int
    lower_contacts: int
    t: np.ndarray
    v: np.ndarray
    multipliers: np.ndarray
    residual: float
    error: float


class _Curve(NamedTuple):
    """The equations of a curve of special points."""

    kind: SpecialKind
    system: System
    space: Unknowns
    shape: OrbitShape


class _Test(NamedTuple):
    kind: CodimensionTwo
    value: Callable[[np.ndarray], float]
    order: int = 1
    turns: int = 0


def codimension_two_points(
    point: SpecialPoint, curve: SpecialCurve, pause: Pause = never_stopped
) -> tuple[CodimensionTwoPoint, ...]:
    """Locate the points of codimension two on a curve of special points, and at its ends.

    Parameters
    ----------
    point : SpecialPoint
        From which the curve was continued.
    curve : SpecialCurve
        Of grazes, saddle-nodes or doublings. Others have none that are known.
    pause : callable
        Called at every point of the curve. To stop the work, raise an exception there.

    Returns
    -------
    tuple of CodimensionTwoPoint
        In order along the curve. Two zeros between neighbouring points of the curve are not seen.
    """
    if point.kind not in _MEETS_A_GRAZE:
        return ()
    space = unknowns(point.oscillator, curve.parameters)
    shape = OrbitShape(point.forcing_periods, point.upper_contacts, int(point.kind == SpecialKind.GRAZING))
    system = special_system(point.kind, space, shape, smooth_side(point, shape))
    on = _Curve(point.kind, system, space, shape)
    places = np.column_stack([curve.t, curve.v, curve.values]) / space.scales
    # Phases begin anew at 1, where the curve goes on.
    places[:, 0] = np.unwrap(places[:, 0], period=1.0)
    found = []
    for test in _tests(on):
        values = []
        for z in places:
            pause()
            values.append(test.value(z))
        signs = np.sign(values)
        for i in np.flatnonzero(signs[1:] * signs[:-1] < 0.0):
            located = _between(on, test, places[i], places[i + 1])
            if located is not None:
                found.append((float(i) + located[0], _described(on, test, *located[1:])))
    ends = [(-1.0, places[0]), (float(len(places)), places[-1])]
    found += [(at, there) for at, z in ends for there in _at_end(on, z)]
    return tuple(there for _, there in sorted(found, key=lambda each: each[0]))


def _between(on: _Curve, test: _Test, before: np.ndarray, after: np.ndarray) -> tuple[float, np.ndarray, float] | None:
    """Part of the way, point and error of the zero of a test function between two points of a curve."""
    from scipy.optimize import brentq  # a third of a second of imports, for those alone who look for such points

    chord = after - before

    def on_curve(part: float) -> np.ndarray:
        landed = solve(on.system, before + part * chord, chord / np.linalg.norm(chord))
        if landed is None:
            raise ArithmeticError("the curve was not found between two of its points")
        return landed.z

    try:
        part, result = brentq(
            lambda part: test.value(on_curve(part)), 0.0, 1.0, xtol=_SHORTEST, rtol=8.0 * np.finfo(float).eps,
            maxiter=_MOST_ITERATIONS, full_output=True,
        )  # fmt: skip
        there = on_curve(part)
    except (ArithmeticError, ValueError):  # a value that is no number is refused by the method, too
        return None
    # A test function that jumps changes its sign without a zero.
    ends, left = (test.value(before), test.value(after)), abs(test.value(there))
    if not (result.converged and left <= 1e-6 * max(abs(end) for end in ends)):
        return None
    return part, there, float((2.0 * _SHORTEST + left / abs(ends[1] - ends[0])) * np.linalg.norm(chord))


def _described(on: _Curve, test: _Test, z: np.ndarray, error: float) -> CodimensionTwoPoint:
    read, evaluated = on.space.read(z), on.system(z)
    assert read is not None and evaluated is not None  # it was solved there
    oscillator, t, v = read
    first = on.space.parameters[0]
    orbit = departures_from(oscillator, first, on.shape, t, v)
    closed = closure(oscillator, first, on.shape, t, v)
    multipliers = np.full(2, np.nan) if closed is None else np.linalg.eigvals(closed.jacobian)
    values = [oscillator.value_of(name) for name in on.space.parameters]
    return CodimensionTwoPoint(
        test.kind, test.order, test.turns, (first, on.space.parameters[1]), (values[0], values[1]), oscillator,
        on.shape.forcing_periods, on.shape.upper_contacts, orbit.lower_contacts, orbit.t, orbit.v,
        multipliers.astype(complex), float(np.abs(evaluated[0]).max()), error,
    )  # fmt: skip


def _tests(on: _Curve) -> Iterator[_Test]:
    if on.kind == SpecialKind.GRAZING:
        yield from _tests_of_grazes(on)
    elif on.kind == SpecialKind.SADDLE_NODE:
        yield _Test(CodimensionTwo.CUSP, partial(_along, on, multiplier=1.0, value=_fold_coefficient))
    else:
        yield _Test(CodimensionTwo.GENERALISED_DOUBLING, partial(_along, on, multiplier=-1.0, value=_cubic_coefficient))


def _tests_of_grazes(on: _Curve) -> Iterator[_Test]:
    def of_turn(z: np.ndarray, value: Callable[[np.ndarray], float]) -> float:
        read = on.space.read(z)
        turn = None if read is None or read[0].is_loose else touch_monodromy(read[0], on.shape, *read[1:])
        return math.nan if turn is None else value(turn)

    def less(multiplier: float, turn: np.ndarray) -> float:
        return float(np.trace(turn)) - multiplier * (1.0 + float(np.linalg.det(turn)))

    def apart(angle: float, turn: np.ndarray) -> float:
        return float(np.trace(turn)) / (2.0 * math.sqrt(float(np.linalg.det(turn)))) - math.cos(angle)

    def push(turn: np.ndarray) -> float:
        return float(turn[0, 1])

    def test(kind: CodimensionTwo, value: Callable[[np.ndarray], float], order: int = 1, turns: int = 0) -> _Test:
        return _Test(kind, partial(of_turn, value=value), order, turns)

    yield test(CodimensionTwo.SADDLE_NODE_GRAZE, partial(less, 1.0))
    yield test(CodimensionTwo.DOUBLING_GRAZE, partial(less, -1.0))
    yield test(CodimensionTwo.NEUTRAL_GRAZE, push)
    for order in range(2, HIGHEST_ORDER + 1):
        for turns in range(1, order):
            if math.gcd(turns, order) == 1:
                yield test(CodimensionTwo.RESONANT_GRAZE, partial(apart, math.pi * turns / order), order, turns)
    for flight in range(1, on.shape.upper_contacts):
        yield _Test(CodimensionTwo.DOUBLE_GRAZE, partial(_faster, on, flight=flight))


def _faster(on: _Curve, z: np.ndarray, flight: int) -> float:
    """Speed of another departure of the orbit less that with which it would touch -beta."""
    read = on.space.read(z)
    if read is None or read[0].is_loose:
        return math.nan
    orbit = departures_from(read[0], on.space.parameters[0], on.shape, *read[1:])
    return float(orbit.v[flight]) - grazing_speed_at(read[0], float(orbit.t[flight]))


class _Bend(NamedTuple):
    """DP^p in scaled (t, v), its null vectors at a multiplier, and DP^p at seven departures along the right one."""

    matrix: np.ndarray
    along: np.ndarray
    across: np.ndarray
    there: np.ndarray
    step: float


def _along(on: _Curve, z: np.ndarray, multiplier: float, value: Callable[[_Bend], float]) -> float:
    """A value of derivatives along the direction of a multiplier, by steps so short that it has settled.

    Too long a step passes a graze, where the map is not smooth. Near its zero a value settles to no part of itself:
    then it is the one whose neighbour is nearest. In scaled unknowns such values are of order 1.
    """
    before, settled, apart = math.nan, math.nan, math.inf
    for n in range(_MOST_HALVINGS):
        bend = _bend(on, z, multiplier, _STEP / 2.0**n)
        now = math.nan if bend is None else value(bend)
        if abs(now - before) < apart:
            settled, apart = now, abs(now - before)
            if apart <= _SETTLED * abs(now):
                return now
        before = now
    return settled if apart <= _SETTLED else math.nan


def _bend(on: _Curve, z: np.ndarray, multiplier: float, step: float) -> _Bend | None:
    def derivative(z: np.ndarray) -> np.ndarray | None:
        read = on.space.read(z)
        closed = None if read is None else closure(read[0], on.space.parameters[0], on.shape, *read[1:])
        return None if closed is None else closed.jacobian * on.space.scales[:2] / on.space.scales[:2, None]

    matrix = derivative(z)
    if matrix is None:
        return None
    left, _, right = np.linalg.svd(matrix - multiplier * np.eye(2))
    # Its sign is that for which the phase grows, so that it is one along a curve.
    along, across = right[-1] * math.copysign(1.0, right[-1][0]), left[:, -1]
    there = [derivative(z + n * step * np.append(along, [0.0, 0.0])) for n in range(-3, 4)]
    known = [each for each in there if each is not None]
    return _Bend(matrix, along, across / (across @ along), np.array(known), step) if len(known) == len(there) else None


def _fold_coefficient(bend: _Bend) -> float:
    """How det(1 - DP^p) changes along the direction of multiplier 1."""
    return float(_FIRST @ np.linalg.det(np.eye(2) - bend.there)) / bend.step


def _cubic_coefficient(bend: _Bend) -> float:
    """Cubic coefficient of P^p on the direction of multiplier -1: positive where the orbit born there attracts on it.

    Kuznetsov, Elements of Applied Bifurcation Theory (2004), Sec. 5.4.
    """
    first = np.tensordot(_FIRST, bend.there, 1) / bend.step
    third = np.tensordot(_SECOND, bend.there, 1) @ bend.along / bend.step**2
    aside = np.linalg.solve(np.eye(2) - bend.matrix, first @ bend.along)
    # The second derivative is symmetric: along the direction of DP^p times `aside` is along `aside` of DP^p times it.
    return float(bend.across @ third) / 6.0 + float(bend.across @ first @ aside) / 2.0


def _at_end(on: _Curve, z: np.ndarray) -> Iterator[CodimensionTwoPoint]:
    """The point at which a curve ends, where another flight grazes there."""
    read = on.space.read(z)
    if read is None or read[0].is_loose:
        return
    orbit = departures_from(read[0], on.space.parameters[0], on.shape, *read[1:])
    turns = _turns(on, orbit)
    if turns > 1:
        yield from _of_shorter(on, z, turns)
        return
    margin = np.abs(grazing_distances(read[0], orbit.t, orbit.v)[0])
    grazes = on.kind == SpecialKind.GRAZING  # with its first flight; another one grazes, too
    others = margin[grazes:]
    if not others.size:
        return
    flight = int(np.argmin(others)) + grazes
    begin = on.space.write(read[0], float(orbit.t[flight]), float(orbit.v[flight]))
    first_one = (on.shape.upper_contacts - flight) % on.shape.upper_contacts if grazes else 0
    shape = on.shape._replace(over=1 | 1 << first_one)
    there = _Curve(on.kind, special_system(on.kind, on.space, shape), on.space, shape)
    test = _Test(_MEETS_A_GRAZE[on.kind], partial(_faster, there, flight=first_one))
    landed = solve(_both(there, test), begin)
    if landed is not None and np.abs(landed.z - begin).max() <= _NEAR_END:
        yield _described(there, test, landed.z, landed.last_step)


def _turns(on: _Curve, orbit: Departures) -> int:
    """How many turns of a shorter orbit the orbit of a curve has nearly become."""
    periods, contacts = on.shape.forcing_periods, on.shape.upper_contacts
    for turns in range(contacts, 1, -1):
        if contacts % turns == periods % turns == 0:
            t, v = (np.roll(each, contacts // turns) - each for each in (orbit.t, orbit.v))
            if max(np.abs(t - np.rint(t)).max(), np.abs(v).max() / on.space.scales[1]) <= _NEAR_END:
                return turns
    return 1


def _of_shorter(on: _Curve, z: np.ndarray, turns: int) -> Iterator[CodimensionTwoPoint]:
    shape = OrbitShape(on.shape.forcing_periods // turns, on.shape.upper_contacts // turns, 1)
    shorter = _Curve(SpecialKind.GRAZING, special_system(SpecialKind.GRAZING, on.space, shape), on.space, shape)
    for test in _tests_of_grazes(shorter):
        landed = solve(_both(shorter, test), z)
        if landed is not None and np.abs(landed.z - z).max() <= _NEAR_END:
            yield _described(shorter, test, landed.z, landed.last_step)
            return


def _both(on: _Curve, test: _Test) -> System:
    """The equations of a curve, and a test function that is zero."""

    def value(z: np.ndarray) -> np.ndarray | None:
        tested = np.array([test.value(z)])
        return tested if np.isfinite(tested).all() else None

    return together(on.system, with_differences(value, on.space))
