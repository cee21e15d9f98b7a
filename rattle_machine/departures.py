"""Departures of a machine by random numbers that are the same for every machine (common random numbers)."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from rattle_kernels import Oscillator, check_oscillator
from rattle_machine.pulses import Distribution, Pressing, Pulses
from worker.errors import InvalidJob
from worker.gear_pair import GearPair
from worker.precision_limits import fastest_of

Machine = GearPair | Oscillator


def oscillator_of(machine: Machine) -> Oscillator:
    """The machine in the model."""
    return machine if isinstance(machine, Oscillator) else machine.oscillator


def sample_of(
    base: Machine, *, size: Any, distribution: Distribution | None, pressing: Pressing, fastest: float | None,
    departures: int, seed: int,
) -> Callable[[Machine], tuple[np.ndarray, np.ndarray]]:  # fmt: skip
    """How departures are drawn.

    Parameters
    ----------
    base : GearPair or Oscillator
        Whose window is meant where none is given.
    size, distribution, pressing
        Departures are those after torque pulses on a quiet machine, as `rattle.pulses` takes them. Without a size they
        are uniform over a window of phases and speeds.
    fastest : float, optional
        Upper end of that window: m/s of a machine, else a speed of the model.
    departures, seed : int

    Returns
    -------
    callable
        ``sample(machine)``: phases and speeds of the model; a speed is NaN where the teeth do not part.

    Raises
    ------
    InvalidJob
        Naming the argument at fault.
    """
    if size is not None:
        if isinstance(base, Oscillator):
            raise InvalidJob("size is a torque pulse in N m s: give a rattle.GearPair, which has inertias", ("size",))
        if fastest is not None:
            raise InvalidJob("fastest is of a window of departures: leave it out beside a size", ("fastest",))
        pulses = Pulses.drawn(size, distribution, departures, seed, pressing)
        pulses.check_pressing(base)
        return lambda machine: pulses.departures_of(machine)[:2]  # type: ignore[arg-type]
    if distribution is not None:
        raise InvalidJob("distribution is of the sizes of pulses: give a size", ("distribution",))
    if isinstance(departures, bool) or not isinstance(departures, int) or departures < 2:
        raise InvalidJob(f"departures must be a whole number from 2 on, not {departures!r}", ("departures",))
    scale = 1.0 if isinstance(base, Oscillator) else base.scales.speed
    top = scale * fastest_of(check_oscillator(oscillator_of(base))) if fastest is None else fastest
    if not 0.0 < top < math.inf:
        raise InvalidJob(f"fastest must be a speed above 0, not {top!r}", ("fastest",))
    phase, part = np.random.default_rng(seed).random((2, departures))
    speed = top * (1.0 - part)  # above 0

    def uniform(machine: Machine) -> tuple[np.ndarray, np.ndarray]:
        return phase, speed / (1.0 if isinstance(machine, Oscillator) else machine.scales.speed)

    return uniform
