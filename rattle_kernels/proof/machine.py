"""Machines within tolerances: every parameter an interval; and the forcing that they feel.

The transmission error is e(t), the sum of all harmonics ``amplitude cos(2 pi (order t + phase))``. Freeplay is
``Phi'' + delta Phi' = a(t)`` with ``a = 4 pi delta + e'' + delta e'``, so that ``4 pi t + e(t)`` solves it.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.model.domain import OutsideDomain
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.numerics.enclosed_functions import wave
from rattle_kernels.numerics.interval import Interval, add, down, multiply, scale
from rattle_kernels.numerics.jit import inlined_as_written, kernel_as_written

_PHASES = 8192
FOUR_PI = Interval(12.566370614359172, 12.566370614359176)


class Machine(NamedTuple):
    """All oscillators of the impacting model with parameters in these intervals.

    ``harmonics``, shape (n, 5), has a row for each: order, least and greatest amplitude, least and greatest phase. The
    first is the eccentricity. The acceleration at rest lies between ``least_acceleration`` and
    ``greatest_acceleration``; no departure slower than ``safe_speed`` falls to -beta.
    """

    damping: Interval
    half_backlash: Interval
    restitution: Interval
    harmonics: np.ndarray
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
        least, greatest = min(least, felt.low), max(greatest, felt.high)
    return least, greatest


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


def machine_of(oscillator: Oscillator, tolerances: dict[str, tuple[float, float]] | None = None) -> Machine:
    """Enclose an oscillator, or all of a range.

    Parameters
    ----------
    oscillator : Oscillator
        Impacting model, checked by the caller.
    tolerances : dict, optional
        Least and greatest value of some of its `parameters`; the others are exact.

    Returns
    -------
    Machine

    Raises
    ------
    OutsideDomain
        If Eq. (8) cannot be proven for all of them.
    """
    ranges = tolerances or {}

    def of(parameter: str) -> Interval:
        value = oscillator.value_of(parameter)
        return Interval(*(float(end) for end in ranges.get(parameter, (value, value))))

    rows = [(1.0, *of("eccentricity"), 0.0, 0.0)]
    rows += [(order, *of(f"amplitude_{order:g}"), *of(f"phase_{order:g}")) for order, _, _ in oscillator.harmonics]
    machine = Machine(of("damping"), of("half_backlash"), of("restitution"), np.array(rows), 0.0, 0.0, 0.0)
    least, greatest = _accelerations(machine, _PHASES)
    if not least > 0.0:
        message = f"the acceleration at rest must be positive at every phase (Eq. 8): it may fall to {least:.6g}"
        raise OutsideDomain("eccentricity", least, "Eq. 8", 0.0, message)
    # While it falls, y'' = a - delta y' is at least a: it falls v^2/(2 a) at most.
    deepest = down(4.0 * down(least * machine.half_backlash.low))
    return machine._replace(
        least_acceleration=least,
        greatest_acceleration=greatest,
        safe_speed=down(math.sqrt(deepest)),
    )
