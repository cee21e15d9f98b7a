"""What the suite measures: each workload with its inputs, their checksum, and an answer that is known otherwise.

Inputs are made of integers, by operations that IEEE 754 rounds alike everywhere. An answer that is known belongs to a
part of the inputs; a method that takes fewer of them is checked on those that both have.
"""

import hashlib
import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rattle_kernels import Oscillator

OSCILLATOR = Oscillator(0.6, 0.1, 0.6)
"""Damping, eccentricity and half backlash of Fig. 7, below."""
STIFF = OSCILLATOR.at(stiffness=1e4)
FASTEST = 7.0
APPLICATIONS = 100
"""Applications of P to each departure."""
ITERATIONS = 1499
"""Applications after which a cell's end is looked up."""
QUIET, RATTLES = 0, 255
"""Ends of a cell beside 1, 2, ...: falls quiet, or comes back to no departure."""
LONGEST_TURN = 12
QUIET_BELOW = 0.1
ANSWERS = Path(__file__).parent / "answers.json"

# Those of the plane's most even sequence (R2), rounded: odd, so that 2^32 points differ in both numbers.
_TIME_STEP, _SPEED_STEP = 3242174889, 2447445413
_POINTS = 250_000
_SIDE = 1000
_BOXES_A_SIDE = 4096
_RETURNED = 1e-6
_SLOWEST = 1e-3
# Of boxes: a wider enclosure says nothing.
_WIDEST = 100.0


class Departures(NamedTuple):
    """Phases and speeds of departures from +beta, shape (n,)."""

    t: np.ndarray
    v: np.ndarray


class Panel(NamedTuple):
    """Phases of the columns of a panel's centres, and speeds of its rows."""

    times: np.ndarray
    speeds: np.ndarray

    @property
    def centres(self) -> Departures:
        """All of them, row by row."""
        return Departures(np.tile(self.times, self.speeds.size), np.repeat(self.speeds, self.times.size))


class Boxes(NamedTuple):
    """Boxes of departures: least and greatest time, least and greatest speed, shape (n, 4)."""

    edges: np.ndarray


Inputs = Departures | Panel | Boxes


def thin(array: np.ndarray, every: int, axes: int = 1) -> np.ndarray:
    """One in `every` items along the first axes, from the middle of each run, so that thinning twice is thinning."""
    return array[(slice(every // 2, None, every),) * axes]


@dataclass(frozen=True)
class Workload:
    """A kind of work, of which methods do a part.

    Parameters
    ----------
    name : str
    definition : str
        In a sentence.
    unit : str
        What is counted.
    units_of_item : int
        Units of one departure, cell or box.
    make : callable
        Makes all inputs.
    sha256 : str
        Checksum of the inputs: their arrays one after the other, float64 with the lowest byte first.
    axes : int
        Axes of an answer that count items.
    known : int
        The answer is known of one in so many items along each axis, a power of five.
    error_of : callable
        How far an answer is from the known one, both along the same items.
    allowed : float
        Largest error of an answer that agrees.
    """

    name: str
    definition: str
    unit: str
    units_of_item: int
    make: Callable[[], Inputs]
    sha256: str
    axes: int
    known: int
    error_of: Callable[[np.ndarray, np.ndarray], float]
    allowed: float

    @cached_property
    def inputs(self) -> Inputs:
        """All inputs, once made."""
        return self.make()

    def check_inputs(self) -> None:
        """Refuse inputs that are not those of the checksum.

        Raises
        ------
        ValueError
        """
        found = checksum(self.inputs)
        if found != self.sha256:
            raise ValueError(f"the inputs of {self.name!r} are not the suite's: their SHA-256 is {found}")

    @property
    def thinnest(self) -> int:
        """The largest power of five that divides the inputs along each axis."""
        return math.gcd(self.inputs[0].shape[0], 5**9)

    def part(self, every: int) -> Inputs:
        """One in `every` of the inputs, a power of five; of a panel along each axis."""
        return type(self.inputs)(*(np.ascontiguousarray(thin(array, every)) for array in self.inputs))

    def items(self, inputs: Inputs) -> int:
        """Departures, cells or boxes of a part."""
        return int(np.prod([array.shape[0] for array in inputs[: self.axes]]))

    def error(self, answer: np.ndarray, every: int) -> float:
        """How far the answer to a part is from the known one.

        Parameters
        ----------
        answer : ndarray
            Of a method, to ``part(every)``.
        every : int

        Returns
        -------
        float
            Finite: what is not a number counts as 1.

        Raises
        ------
        ValueError
            If the answer has not the shape that the inputs ask for.
        """
        both = max(every, self.known)
        mine, known = thin(answer, both // every, self.axes), thin(self.answer, both // self.known, self.axes)
        if (mine.ndim, mine.shape[: self.axes]) != (known.ndim, known.shape[: self.axes]):
            raise ValueError(
                f"an answer to {self.name!r} has one item for each of the inputs, not shape {answer.shape}"
            )
        return self.error_of(mine, known)

    @cached_property
    def answer(self) -> np.ndarray:
        """The known answer; not numbers where an image is not known."""
        told = json.loads(ANSWERS.read_text())[self.name]
        if isinstance(told[0], str):
            return np.array([[RATTLES if end == "x" else int(end, 36) for end in row] for row in told], np.uint8)
        return np.array([[np.nan if number is None else float.fromhex(number) for number in row] for row in told])


def checksum(inputs: Inputs) -> str:
    """SHA-256 of inputs, as 64 digits."""
    digest = hashlib.sha256()
    for array in inputs:
        digest.update(array.astype("<f8").tobytes())
    return digest.hexdigest()


def _numbers() -> tuple[np.ndarray, np.ndarray]:
    number = np.arange(1, _POINTS + 1, dtype=np.uint64)
    return number * np.uint64(_TIME_STEP) % np.uint64(2**32), number * np.uint64(_SPEED_STEP) % np.uint64(2**32)


def _departures() -> Departures:
    t, v = _numbers()
    return Departures(t / 2.0**32, v * FASTEST / 2.0**32)


def _panel() -> Panel:
    centres = np.arange(_SIDE) + 0.5
    return Panel(centres * (1.0 / _SIDE), centres * (FASTEST / _SIDE))


def _boxes() -> Boxes:
    column, row = (numbers // np.uint64(2**32 // _BOXES_A_SIDE) for numbers in _numbers())
    edges = [column, column + np.uint64(1), row * FASTEST, (row + np.uint64(1)) * FASTEST]
    return Boxes(np.stack([edge / _BOXES_A_SIDE for edge in edges], axis=1))


def ends_of(apply: Callable[[np.ndarray, np.ndarray, int], Departures], centres: Departures) -> np.ndarray:
    """Ends of cells by their definition, for methods that have the map alone.

    Parameters
    ----------
    apply : callable
        Applies P so many times to departures; speeds that are not numbers where contact is permanent.
    centres : Departures

    Returns
    -------
    ndarray of uint8, shape (n,)
        QUIET, the number of applications after which the landing point comes back, or RATTLES.
    """
    landing = apply(*centres, ITERATIONS)
    ends = np.full(centres.t.size, QUIET, np.uint8)
    rattling = np.flatnonzero(landing.v >= QUIET_BELOW)
    if rattling.size == 0:
        return ends
    landing = Departures(*(array[rattling] for array in landing))
    found, turned = np.full(rattling.size, RATTLES, np.uint8), landing
    for turn in range(1, LONGEST_TURN + 1):
        turned = apply(*turned, 1)
        back = (_apart(turned.t, landing.t) < _RETURNED) & (np.abs(turned.v - landing.v) < _RETURNED)
        found[back & (found == RATTLES)] = turn
    ends[rattling] = found
    return ends


def _apart(t: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Distance of phases around the circle."""
    return np.abs((t - other + 0.5) % 1.0 - 0.5)


def _error_of_images(answer: np.ndarray, known: np.ndarray) -> float:
    compared = ~np.isnan(known[:, 0])
    answer, known = answer[compared], known[compared]
    speeds = np.abs(answer[:, 1] - known[:, 1]) / np.maximum(known[:, 1], _SLOWEST)
    errors = np.maximum(_apart(answer[:, 0], known[:, 0]), speeds)
    return float(np.nan_to_num(errors, nan=1.0, posinf=1.0).max(initial=0.0))


def _error_of_ends(answer: np.ndarray, known: np.ndarray) -> float:
    return float((answer != known).mean())


def _error_of_hulls(answer: np.ndarray, known: np.ndarray) -> float:
    early, late, low, high = answer.T
    if ((known[:, 0] < early) | (known[:, 0] > late) | (known[:, 1] < low) | (known[:, 1] > high)).any():
        return 1.0
    narrow = (late - early < _WIDEST / _BOXES_A_SIDE) & (high - low < _WIDEST * FASTEST / _BOXES_A_SIDE)
    return float(1.0 - narrow.mean())


WORKLOADS = {
    workload.name: workload
    for workload in (
        Workload(
            "applications",
            "P is applied 100 times to each departure, at damping 0.6, eccentricity 0.1 and half backlash 0.6.",
            "applications",
            APPLICATIONS,
            _departures,
            "e0705f95e258530f320a53dda077c0ce54e838a09a1acb19643f57bc17e99f83",
            1,
            625,
            _error_of_images,
            1e-8,
        ),
        Workload(
            "basin",
            "Each cell of the same oscillator's panel is followed to its end: quiet, a periodic motion, or chaos.",
            "cells",
            1,
            _panel,
            "4385c4211e2332d6caf0352a161f35078c4d4233c630947af1bb6cc4e99ace43",
            2,
            25,
            _error_of_ends,
            0.01,
        ),
        Workload(
            "stiff basin",
            "The same panel with contacts of stiffness 10,000 in place of impacts.",
            "cells",
            1,
            _panel,
            "4385c4211e2332d6caf0352a161f35078c4d4233c630947af1bb6cc4e99ace43",
            2,
            25,
            _error_of_ends,
            0.01,
        ),
        Workload(
            "boxes",
            "All images under P of the departures of a box are enclosed, with every rounding counted.",
            "boxes",
            1,
            _boxes,
            "55d09ffa0ac8e8783e3ac486b6f59f8a563914175f24c21e1fbf29e3ae087670",
            1,
            625,
            _error_of_hulls,
            0.02,
        ),
    )
}
"""By name."""
