"""From which value of a parameter on: a share of quiet, or of another motion, is reached.

The share at a value is that of a sample, and the sample is the same at every value (common random numbers): what
differs from one value to the next is the machine alone. A scan of the interval finds where the share crosses the one
that is asked for, and bisection narrows the first crossing down until its bracket is small against what the sample
cannot tell. docs/theory/pulses.md derives the error.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle_kernels import Oscillator, OutsideDomain, check_oscillator, shares_of
from rattle_machine.departures import Machine, oscillator_of, sample_of
from rattle_machine.numbers import number_of, unit_of, with_number
from rattle_machine.pulses import Distribution, Pressing
from worker.errors import InvalidJob
from worker.gear_pair import GearPair

if TYPE_CHECKING:
    from worker.gear_pair import Quantity

QUIET = "permanent contact"
# The bracket is narrowed until its half is this part of what the sample cannot tell, 40 times at most.
_SMALL_PART = 0.1
_ROUNDS = 40
# A slope is taken over a change of the share that is so many standard errors of it.
_CLEAR = 4.0


@dataclass(frozen=True)
class Threshold:
    """Where a share is reached.

    Attributes
    ----------
    parameter, unit : str
        What is varied, and in which unit; without one it is a pure number.
    value : float
        At which the share is reached: the middle of the bracket.
    error : float
        Standard error of the share over the slope, and half the bracket.
    bracket : (float, float)
        Between these values the share of the sample crosses the one that is asked for.
    shares : (float, float)
        Of the sample, at both.
    share, share_error : float
        What is asked for, and its standard error in a sample of this size.
    slope : float
        Change of the share with the parameter there.
    motion : str
        Whose share it is.
    departures : int
        In the sample.
    crossings : tuple of (float, float)
        Where the scan sees the share cross, from the lower end of the interval on. The first one was bracketed: where
        there are several, the share is not monotone.
    scanned : tuple of (float, float)
        Values of the scan, and the share at each.
    """

    parameter: str
    unit: str
    value: float
    error: float
    bracket: tuple[float, float]
    shares: tuple[float, float]
    share: float
    share_error: float
    slope: float
    motion: str
    departures: int
    crossings: tuple[tuple[float, float], ...]
    scanned: tuple[tuple[float, float], ...]

    def to_dict(self) -> dict[str, Any]:
        """All of it, for JSON.

        Returns
        -------
        dict
        """
        return asdict(self)

    def __str__(self) -> str:
        """In sentences."""
        unit = f" {self.unit}" if self.unit else ""
        told = (
            f"{self.parameter} = {self.value:.6g} ± {self.error:.2g}{unit}: {self.share:g} of {self.departures:,} "
            f"departures end in {self.motion} there ({self.shares[0]:.4g} at {self.bracket[0]:.6g}, "
            f"{self.shares[1]:.4g} at {self.bracket[1]:.6g})"
        )
        others = [f"{low:.4g} to {high:.4g}" for low, high in self.crossings[1:]]
        return told + (f"; the share crosses again within {', '.join(others)}{unit}" if others else "")


def threshold(
    machine: "GearPair | Oscillator | str | Path",
    parameter: str,
    share: float,
    *,
    between: "tuple[Quantity, Quantity]",
    motion: str = QUIET,
    size: "Quantity | Path | Sequence[float] | np.ndarray | None" = None,
    distribution: Distribution | None = None,
    pressing: Pressing = "bounces",
    fastest: float | None = None,
    departures: int = 4096,
    seed: int = 0,
    scan: int = 9,
) -> Threshold:
    """Find the value of a parameter at which a share of a motion is reached.

    Parameters
    ----------
    machine : GearPair, Oscillator, str or path
        A machine in its own units, or a TOML file of it; or an oscillator of the model.
    parameter : str
        What is varied. Of a machine ``speed`` (drag follows the drag law), another number of it, or an order of the
        transmission error as in ``transmission_error.2.amplitude``. Of an oscillator one of its ``parameters``.
    share : float
        The share to be reached, between 0 and 1.
    between : (float or str, float or str)
        The interval in which it is looked for; of a machine in SI units, or texts with units.
    motion : str
        Whose share, by its name: permanent contact, which is quiet, or another one, as in ``P(1,1,0)``.
    size, distribution, pressing
        Departures are those after torque pulses on a quiet machine, as ``rattle.pulses`` takes them. Without a size
        they are uniform over a window of phases and speeds.
    fastest : float, optional
        Upper end of that window: m/s of a machine, else a speed of the model. By default it follows the machine as it
        is given, and stays where it is as the parameter varies.
    departures : int
        In the sample.
    seed : int
        Of the sample, which is the same at every value.
    scan : int
        Values, evenly over the interval, at which crossings are looked for.

    Returns
    -------
    Threshold

    Raises
    ------
    InvalidJob
        If an argument is wrong, a value of the interval is none that the machine can have, or the share is not reached:
        the message says the shares at both ends. It is a ValueError.

    Examples
    --------
    >>> from rattle_kernels import Oscillator
    >>> import rattle
    >>> found = rattle.threshold(Oscillator(damping=0.6), "eccentricity", 0.8, between=(0.06, 0.12), departures=512)
    >>> 0.06 < found.value < 0.12 and found.bracket[0] <= found.value <= found.bracket[1]
    True
    """
    _check(share, scan)
    base, at, low, high = _varied(machine, parameter, between)
    ends_of = sample_of(
        base, size=size, distribution=distribution, pressing=pressing, fastest=fastest, departures=departures, seed=seed
    )
    share_at = _share_at(parameter, at, ends_of, motion)
    scanned = [(value, share_at(value)) for value in np.linspace(low, high, scan).tolist()]
    crossings = [
        (left, right)
        for left, right in zip(scanned[:-1], scanned[1:], strict=True)
        if (left[1] < share) != (right[1] < share)
    ]
    unit = "" if isinstance(base, Oscillator) else unit_of(parameter)
    if not crossings:
        told = f"{scanned[0][1]:.4g} at {low:.6g}, {scanned[-1][1]:.4g} at {high:.6g}"
        most, least = max(each[1] for each in scanned), min(each[1] for each in scanned)
        raise InvalidJob(
            f"a share {share:g} of {motion} is not reached between {low:.6g} and {high:.6g}{unit and ' ' + unit}: it "
            f"is {told}, and {least:.4g} to {most:.4g} at the {scan} values looked at",
            ("share",),
        )
    error = math.sqrt(share * (1.0 - share) / departures)
    left, right, slope = _narrowed(share_at, crossings[0], share, error)
    half = 0.5 * (right[0] - left[0])
    return Threshold(
        parameter, unit, left[0] + half, error / abs(slope) + half, (left[0], right[0]), (left[1], right[1]), share,
        error, slope, motion, departures, tuple((one[0], other[0]) for one, other in crossings), tuple(scanned),
    )  # fmt: skip


def _check(share: float, scan: int) -> None:
    if isinstance(share, bool) or not isinstance(share, int | float) or not 0.0 < share < 1.0:
        raise InvalidJob(f"share must be between 0 and 1, neither of them, not {share!r}", ("share",))
    if isinstance(scan, bool) or not isinstance(scan, int) or scan < 2:
        raise InvalidJob(f"scan must be a whole number from 2 on, not {scan!r}", ("scan",))


def _narrowed(
    share_at: Callable[[float], float], crossing: tuple[tuple[float, float], tuple[float, float]], share: float,
    error: float,
) -> tuple[tuple[float, float], tuple[float, float], float]:  # fmt: skip
    """Ends of a narrower bracket, (value, share) each, and the slope there."""
    left, right = crossing
    slope = (right[1] - left[1]) / (right[0] - left[0])
    for _ in range(_ROUNDS):
        if right[0] - left[0] <= 2.0 * _SMALL_PART * error / abs(slope):
            break
        middle = 0.5 * (left[0] + right[0])
        if not left[0] < middle < right[0]:
            break
        at_middle = middle, share_at(middle)
        left, right = (at_middle, right) if (at_middle[1] < share) == (left[1] < share) else (left, at_middle)
        # Over less than that, the slope would be of the sample's own steps.
        if abs(right[1] - left[1]) >= _CLEAR * error:
            slope = (right[1] - left[1]) / (right[0] - left[0])
    return left, right, slope


def _varied(
    machine: "GearPair | Oscillator | str | Path", parameter: str, between: Any
) -> tuple[Machine, Callable[[Any], Machine], float, float]:
    """The machine as given, the machine at a value of the parameter, and the ends of the interval as numbers."""
    if not isinstance(between, Sequence) or isinstance(between, str) or len(between) != 2:
        raise InvalidJob(f"between must be two values of {parameter}, not {between!r}", ("between",))
    if isinstance(machine, Oscillator):
        low, high = _numbers(parameter, between)
        base: Machine = check_oscillator(machine)

        def at(value: Any) -> Machine:
            return check_oscillator(machine.at(**{parameter: value}))

        try:
            machine.value_of(parameter)
        except ValueError as error:
            raise InvalidJob(str(error), ("parameter",)) from None
        return base, at, low, high
    pair = GearPair.of(machine)
    ends = [with_number(pair, parameter, value) for value in between]
    low, high = _numbers(parameter, [number_of(each, parameter) for each in ends])
    return pair, lambda value: with_number(pair, parameter, value), low, high


def _numbers(parameter: str, between: Sequence[Any]) -> tuple[float, float]:
    for value in between:
        if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not math.isfinite(value):
            raise InvalidJob(f"between must be two values of {parameter}, not {value!r}", ("between",))
    low, high = sorted(map(float, between))
    if low == high:
        raise InvalidJob(f"between must be two different values of {parameter}, not {low:g} twice", ("between",))
    return low, high


def _share_at(
    parameter: str, at: Callable[[Any], Machine], ends_of: Callable[[Machine], tuple[np.ndarray, np.ndarray]],
    motion: str,
) -> Callable[[float], float]:  # fmt: skip
    """Share of the sample that ends in the motion, at a value of the parameter."""

    def share_at(value: float) -> float:
        try:
            machine = at(value)
            t, v = ends_of(machine)
            parts = np.isfinite(v)
            held = 0 if motion != QUIET else int((~parts).sum())
            if not parts.any():
                return held / t.size
            found = shares_of(oscillator_of(machine), t[parts], v[parts])
        except (OutsideDomain, InvalidJob) as error:
            raise InvalidJob(f"{parameter} = {value:.6g}: {error}", ("between",)) from None
        named = np.array([attractor.name == motion for attractor in found.attractors])
        return float((int(named[found.solution].sum()) + held) / t.size)

    return share_at
