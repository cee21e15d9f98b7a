"""The first of many oscillators that a check refuses, found with few checks.

A check is convex in a parameter if between two accepted values every value is accepted. Then both ends tell of all
values between them, and the first refused one is found by halving.

The domain of the map is convex in each number of the oscillator but the phases of harmonics: the acceleration at rest
(Eq. 8) is linear in the damping and in each amplitude at every phase, and all other bounds are monotonic or have one
maximum. The reaction of contact without ringing (Eq. 3) is linear in the amplitudes alone where the stiffness is
finite: it has a resonance. In the other parameters `pressed_for_sure` decides most values at once, and the rest is
checked one by one.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from rattle_kernels import Oscillator, OutsideDomain
from worker.errors import InvalidJob
from worker.jobs.budget import spend
from worker.jobs.design import Design, SweepAxis, changes_at
from worker.jobs.swept_parameter import SweptParameter, as_array, is_of_harmonic, is_phase

Fault = OutsideDomain | InvalidJob
_TWO_PI = 2.0 * math.pi
# What lies as close to a bound as rounding is decided one by one.
_ROUNDING = 1e-9


def first_fault(
    oscillator: Oscillator,
    axes: Sequence[SweepAxis],
    check: Callable[[Oscillator], Oscillator],
    convex: Iterable[str] | None,
) -> tuple[tuple[int, ...], Fault] | None:
    """The first of the oscillators of a sweep that a check refuses.

    Parameters
    ----------
    oscillator : Oscillator
    axes : sequence of SweptParameter or Design
    check : callable
        Raises `OutsideDomain` or `InvalidJob`.
    convex : iterable of str, optional
        Parameters in which the check is convex; by default all but phases.

    Returns
    -------
    place : tuple of int
        Index along each axis.
    error : OutsideDomain or InvalidJob
    """
    errors: dict[tuple[int, ...], Fault] = {}

    def refused(place: tuple[int, ...]) -> bool:
        spend()
        try:
            check(oscillator.at(**changes_at(axes, place)))
        except (OutsideDomain, InvalidJob) as error:
            errors[place] = error
        return place in errors

    place = _first_place(oscillator, axes, refused, convex)
    return None if place is None else (place, errors[place])


def _first_place(
    oscillator: Oscillator, axes: Sequence[SweepAxis], refused: Callable[[tuple[int, ...]], bool],
    convex: Iterable[str] | None,
) -> tuple[int, ...] | None:  # fmt: skip
    vary = [axis for axis in axes if not isinstance(axis, Design)]
    if len(vary) < len(axes):
        # Along a curve no check is convex: each machine is checked.
        return first_refused([Axis(axis.size, False) for axis in axes], refused)
    surely = partial(pressed_for_sure, oscillator, vary, quiet=convex is not None)
    return first_refused(_axes_of(vary, convex), refused, surely)


class Axis(NamedTuple):
    """Number of values of a parameter, and whether the check is convex in it."""

    size: int
    convex: bool


def first_refused(
    axes: Sequence[Axis],
    refused: Callable[[tuple[int, ...]], bool],
    accepted: Callable[[], np.ndarray] = lambda: np.array(False),
) -> tuple[int, ...] | None:
    """Place of the first refused combination of values, the last axis fastest; None if there is none.

    Parameters
    ----------
    axes : sequence of Axis
    refused : callable
        Whether the check refuses the combination at a place.
    accepted : callable
        Which combinations the check accepts for sure, so far as it is not convex in all parameters. What else it checks
        is convex in all of them.

    Returns
    -------
    tuple of int, optional

    Examples
    --------
    >>> first_refused([Axis(1_000_000, True)], lambda place: place[0] > 314_159)
    (314160,)
    """
    found = _first((), tuple(axis.size for axis in axes), refused)
    if all(axis.convex for axis in axes):
        return found
    shape = tuple(axis.size for axis in axes)
    for number in np.flatnonzero(~np.broadcast_to(accepted(), shape)):
        place = tuple(map(int, np.unravel_index(number, shape)))
        if found is not None and place >= found:
            break
        if refused(place):
            return place
    return found


def _first(
    place: tuple[int, ...], sizes: tuple[int, ...], refused: Callable[[tuple[int, ...]], bool]
) -> tuple[int, ...] | None:
    """A refused place. No earlier one is refused by what is convex in all parameters."""
    if not sizes:
        return place if refused(place) else None
    size, rest = sizes[0], sizes[1:]
    first = _first((*place, 0), rest, refused)
    if first is not None or size == 1:
        return first
    low, high = 0, size - 1
    last = _first((*place, high), rest, refused)
    # All before `low` are accepted. Where `high` is refused, so are all from the first refused one on.
    while last is not None and high - low > 1:
        middle = (low + high) // 2
        found_there = _first((*place, middle), rest, refused)
        if found_there is None:
            low = middle
        else:
            high, last = middle, found_there
    return last


def _axes_of(vary: Iterable[SweptParameter], convex: Iterable[str] | None) -> list[Axis]:
    """Axes of swept parameters: a check is always convex in half backlash, eccentricity and amplitudes."""
    return [Axis(len(swept.values), _is_convex(swept.parameter, convex)) for swept in vary]


def _is_convex(parameter: str, convex: Iterable[str] | None) -> bool:
    if is_of_harmonic(parameter):
        return not is_phase(parameter)
    return convex is None or parameter in ("eccentricity", "half_backlash", *convex)


def pressed_for_sure(oscillator: Oscillator, vary: Sequence[SweptParameter], *, quiet: bool) -> np.ndarray:
    """Whether each combination of values is within Eq. (8) for sure, or with `quiet` within Eq. (3).

    Both say that a trigonometric polynomial is positive at every phase: the acceleration at rest, and the reaction in
    contact without ringing. It is where its mean exceeds the amplitudes of its harmonics. With one harmonic that is the
    bound itself, with several it is stricter.

    Parameters
    ----------
    oscillator : Oscillator
    vary : sequence of SweptParameter
        Values that are each within their own bounds.
    quiet : bool

    Returns
    -------
    ndarray of bool
        One axis for each parameter. False says nothing.

    Examples
    --------
    >>> stiffness = SweptParameter("stiffness", (10.0, 20.0, 1e3))
    >>> pressed_for_sure(Oscillator(eccentricity=0.15, stiffness=10.0), [stiffness], quiet=True).tolist()
    [True, False, True]
    """
    shape = tuple(len(swept.values) for swept in vary)
    grid = np.meshgrid(*(as_array(swept.values) for swept in vary), indexing="ij", sparse=True)
    values = dict(zip((swept.parameter for swept in vary), grid, strict=True))

    def value(name: str) -> Any:
        return values[name] if name in values else oscillator.value_of(name)

    with np.errstate(all="ignore"):  # what cannot be computed is not for sure
        damping, square = value("damping"), 2.0 * value("stiffness")
        mean, most = 2.0 * _TWO_PI * damping, 0.0
        for order, _, _ in oscillator.all_harmonics:
            spend()
            rate = _TWO_PI * order
            amplitude = np.abs(value("eccentricity" if order == 1.0 else f"amplitude_{order:g}"))
            of_order = amplitude * rate * np.hypot(rate, damping)
            if quiet:
                drag = damping / square + 2.0 * value("contact_damping") / np.sqrt(square)
                of_order = of_order / np.hypot(1.0 - rate * rate / square, rate * drag)
            most = most + of_order
        return np.broadcast_to(mean - most > _ROUNDING * (mean + most), shape)
