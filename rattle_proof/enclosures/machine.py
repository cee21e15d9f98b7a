"""Machines within tolerances: every parameter an interval; and the forcing that they feel.

The transmission error is e(t), the sum of all harmonics ``amplitude cos(2 pi (order t + phase))``. Freeplay is
``Phi'' + delta Phi' = a(t)`` with ``a = 4 pi delta + e'' + delta e'``, so that ``4 pi t + e(t)`` solves it.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from rattle_kernels.model.domain import OutsideDomain
from rattle_kernels.model.harmonics import Harmonic
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.jit import inlined_as_written, kernel_as_written
from rattle_proof.enclosures.enclosed_functions import wave
from rattle_proof.enclosures.interval import Interval, add, down, middle, multiply, point, scale

_PHASES = 8192
MOST_PARTS = 16
"""Into how many parts tolerances are cut at most, a lattice for each."""
# Up to this part of what it changes a tolerance is narrow enough for one lattice.
_NARROW = 0.002
FOUR_PI = Interval(12.566370614359172, 12.566370614359176)


class Parameters(NamedTuple):
    """Parameters of the impacting model, each an interval.

    ``harmonics``, shape (n, 5), has a row for each: order, least and greatest amplitude, least and greatest phase. The
    first is the eccentricity.
    """

    damping: Interval
    half_backlash: Interval
    restitution: Interval
    harmonics: np.ndarray


class Machine(NamedTuple):
    """All oscillators of the impacting model with parameters in these intervals, as `Parameters` has them.

    ``centre`` is one of them, and ``exact`` says that there is no other. The acceleration at rest lies between
    ``least_acceleration`` and ``greatest_acceleration``; no departure slower than ``safe_speed`` falls to -beta.
    """

    damping: Interval
    half_backlash: Interval
    restitution: Interval
    harmonics: np.ndarray
    centre: Parameters
    exact: bool
    least_acceleration: float
    greatest_acceleration: float
    safe_speed: float


class Error(NamedTuple):
    """Transmission error and its first two derivatives by time."""

    value: Interval
    rate: Interval
    bend: Interval


@inlined_as_written
def error_at(machine, t):
    """Transmission error and its derivatives at all times of an interval."""
    value, rate, bend = Interval(0.0, 0.0), Interval(0.0, 0.0), Interval(0.0, 0.0)
    for n in range(machine.harmonics.shape[0]):
        order = machine.harmonics[n, 0]
        amplitude = Interval(machine.harmonics[n, 1], machine.harmonics[n, 2])
        phase = Interval(machine.harmonics[n, 3], machine.harmonics[n, 4])
        angle = wave(add(scale(t, order), phase))
        speed = scale(FOUR_PI, 0.5 * order)
        first = multiply(speed, amplitude)
        value = add(value, multiply(amplitude, angle.cosine))
        rate = add(rate, multiply(scale(first, -1.0), angle.sine))
        bend = add(bend, multiply(scale(multiply(speed, first), -1.0), angle.cosine))
    return Error(value, rate, bend)


@inlined_as_written
def acceleration(machine, error):
    """a(t): what an object at rest in freeplay feels, positive at every phase by Eq. (8)."""
    drag = multiply(machine.damping, add(FOUR_PI, error.rate))
    return add(drag, error.bend)


@kernel_as_written
def _accelerations(machine, phases):
    least, greatest = math.inf, 0.0
    for i in range(phases):
        felt = acceleration(machine, error_at(machine, Interval(i / phases, (i + 1) / phases)))
        if not felt.low <= felt.high:
            return math.nan, math.nan
        least, greatest = min(least, felt.low), max(greatest, felt.high)
    return least, greatest


ABOVE_ZERO = ("damping", "half_backlash", "restitution")
"""Parameters that no machine has at 0: their tolerances end above it."""


def parameters_within(oscillator: Oscillator) -> dict[str, tuple[float, float]]:
    """Parameters that may have a tolerance, and between which values each must lie.

    Parameters
    ----------
    oscillator : Oscillator

    Returns
    -------
    dict
    """
    ranges = {"damping": (0.0, math.inf), "eccentricity": (0.0, math.inf), "half_backlash": (0.0, math.inf)}
    ranges["restitution"] = (0.0, 1.0)
    for order, _, _ in oscillator.harmonics:
        ranges |= {f"amplitude_{order:g}": (0.0, math.inf), f"phase_{order:g}": (-1.0, 2.0)}
    return ranges


def _parameters(oscillator: Oscillator, ranges: dict[str, tuple[float, float]]) -> Parameters:
    def of(parameter: str) -> Interval:
        value = oscillator.value_of(parameter)
        return Interval(*(float(end) for end in ranges.get(parameter, (value, value))))

    rows = [(1.0, *of("eccentricity"), 0.0, 0.0)]
    rows += [(order, *of(f"amplitude_{order:g}"), *of(f"phase_{order:g}")) for order, _, _ in oscillator.harmonics]
    return Parameters(of("damping"), of("half_backlash"), of("restitution"), np.array(rows))


def machine_of(oscillator: Oscillator, tolerances: dict[str, tuple[float, float]] | None = None) -> Machine:
    """Enclose an oscillator, or all of a range.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model, checked by the caller.
    tolerances : dict, optional
        Least and greatest value of some of its `parameters`, its own between them; the others are exact.

    Returns
    -------
    Machine

    Raises
    ------
    OutsideDomain
        If Eq. (8) cannot be proven for all of them.
    """
    centre = _parameters(oscillator, {})
    machine = Machine(*_parameters(oscillator, tolerances or {}), centre, not tolerances, 0.0, 0.0, 0.0)
    least, greatest = _accelerations(machine, _PHASES)
    if not least > 0.0:
        where = " within the tolerances" if tolerances else ""
        message = f"the acceleration at rest must be positive at every phase (Eq. 8): it may fall to {least:.6g}{where}"
        raise OutsideDomain("eccentricity", least, "Eq. 8", 0.0, message)
    # While it falls, y'' = a - delta y' is at least a: it falls v^2/(2 a) at most.
    deepest = down(4.0 * down(least * machine.half_backlash.low))
    return machine._replace(
        least_acceleration=least,
        greatest_acceleration=greatest,
        safe_speed=down(math.sqrt(deepest)),
    )


def centre_of(machine: Machine) -> Oscillator:
    """The oscillator that is a machine's centre.

    Parameters
    ----------
    machine : Machine

    Returns
    -------
    Oscillator
    """
    one = machine.centre
    harmonics = tuple(Harmonic(row[0], row[1], row[3]) for row in one.harmonics[1:].tolist())
    numbers = one.damping.low, float(one.harmonics[0, 1]), one.half_backlash.low
    return Oscillator(*numbers, restitution=one.restitution.low, harmonics=harmonics)


def halves_of(machine: Machine) -> list[Machine]:
    """Cut the tolerance of that parameter which changes the acceleration at rest most.

    Parameters
    ----------
    machine : Machine

    Returns
    -------
    list of Machine
        Two, that together hold the same machines, each with its own centre; none if nothing changes the acceleration.
    """
    return _halves_by(machine, {place: size for place, size in _sizes(machine).items() if place.changes_acceleration})


def parts_of(machine: Machine) -> list[Machine]:
    """Cut tolerances until each is narrow, or there are `MOST_PARTS`: the widest first, and all parts alike.

    Parameters
    ----------
    machine : Machine

    Returns
    -------
    list of Machine
        They hold the same machines together, each with its own centre.
    """
    parts = [machine]
    while 2 * len(parts) <= MOST_PARTS and max(_sizes(parts[0]).values()) > _NARROW:
        parts = [half for part in parts for half in _halves_by(part, _sizes(parts[0]))]
    return parts


class _Place(NamedTuple):
    """Where a parameter stands in `Parameters`: which of them, and of a harmonic its row and first column."""

    name: str
    row: int = 0
    column: int = 0

    @property
    def changes_acceleration(self) -> bool:
        return self.name in ("damping", "harmonics")


def _sizes(machine: Machine) -> dict[_Place, float]:
    """Each tolerance as a part of what it changes: of harmonics that is the acceleration at rest, 4 pi delta."""
    intervals = {_Place(name): getattr(machine, name) for name in ("damping", "half_backlash", "restitution")}
    sizes = {place: (each.high - each.low) / each.high for place, each in intervals.items()}
    for row, (order, small, large, early, late) in enumerate(machine.harmonics.tolist()):
        bend = (2.0 * math.pi * order) ** 2 / (4.0 * math.pi * machine.damping.high)
        sizes[_Place("harmonics", row, 1)] = bend * (large - small)
        sizes[_Place("harmonics", row, 3)] = bend * large * 2.0 * math.pi * (late - early)
    return sizes


def _halves_by(machine: Machine, sizes: dict[_Place, float]) -> list[Machine]:
    """Two halves by the largest of some tolerances; none if all are 0."""
    place = max(sizes, key=lambda each: sizes[each])
    if sizes[place] == 0.0:
        return []
    ends, whole = slice(place.column, place.column + 2), getattr(machine, place.name)
    a = Interval(*whole[place.row, ends].tolist()) if place.name == "harmonics" else whole
    halves = []
    for half in (Interval(a.low, middle(a)), Interval(middle(a), a.high)):
        within: Any = half
        one: Any = point(middle(half))
        if place.name == "harmonics":
            within, one = whole.copy(), machine.centre.harmonics.copy()
            within[place.row, ends], one[place.row, ends] = half, middle(half)
        changed, centre = {place.name: within}, {place.name: one}
        halves.append(machine._replace(**changed, centre=machine.centre._replace(**centre)))
    return halves
