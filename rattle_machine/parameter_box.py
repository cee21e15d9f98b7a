"""Parameters of the model within limits of a machine's numbers: an interval of each that holds those of every machine.

The formulas are those of `worker.gear_pair`. Each is a product or quotient of numbers that are not negative, with each
number in it once. So the ends of a parameter are those of the numbers. They are exact, as rationals, but for pi and the
exponential function, of which 50 digits are taken. Then they move outwards by more than a dozen floats are rounded: an
interval also holds what a `GearPair` computes.

Two parameters with a number in common differ together from machine to machine. In the box they differ apart, so it
holds more oscillators than there are machines.
"""

import math
from collections.abc import Mapping
from decimal import Decimal, localcontext
from fractions import Fraction
from typing import NamedTuple

from rattle_kernels import Harmonic, Oscillator
from rattle_machine.numbers import number_of
from worker.gear_pair import GearPair

Limits = Mapping[str, tuple[float, float]]
"""Least and greatest value of numbers of a machine in SI units, in the order in which machines are given them."""

_PI_DIGITS = "3.1415926535897932384626433832795028841971693993751"
_PI = Fraction(_PI_DIGITS)
_DIGITS = 50
_OUTWARDS = Fraction(1, 2**45)
_EXACTLY_ONE = 1.0, 1.0


class ParameterBox(NamedTuple):
    """Intervals of parameters.

    Parameters
    ----------
    oscillator : Oscillator
        That in the middle.
    within : dict
        Least and greatest value of each parameter, by its name in `Oscillator.parameters`. Phases are modulo 1.
    speed : tuple of float
        One unit of the model's speed, m/s.
    """

    oscillator: Oscillator
    within: dict[str, tuple[float, float]]
    speed: tuple[float, float]


class _Numbers(NamedTuple):
    """All numbers from ``low`` to ``high``, exactly."""

    low: Fraction
    high: Fraction


def parameter_box(pair: GearPair, limits: Limits) -> ParameterBox:
    """Enclose the parameters of all machines within limits.

    Parameters
    ----------
    pair : GearPair
        Of the impacting model, with the numbers that have no limits.
    limits : mapping

    Returns
    -------
    ParameterBox
    """

    def of(name: str) -> _Numbers:
        value = number_of(pair, name) or 0.0
        return _Numbers(*(Fraction(end) for end in limits.get(name, (value, value))))

    turns = _one(Fraction(pair.turns))
    speed, radius, ratio = of("speed"), of("base_radius"), of("inertia_ratio")
    wide = _times(radius, _Numbers(1 + ratio.low, 1 + ratio.high))
    reach = _times(turns, wide)  # two units of length
    # A drag torque that is proportional to speed is that of the pair at the pair's speed.
    other_speed = _one(Fraction(pair.speed)) if _drag_follows_speed(pair, limits) else speed
    drag = _over(of("drag_torque"), _times(of("inertia"), speed, other_speed))
    within = {
        "damping": _outwards(_times(_one(2 * _PI), turns, drag)),
        "eccentricity": (0.0, 0.0),
        "half_backlash": _outwards(_over(of("backlash"), reach)),
        "restitution": _restitution(pair, limits),
    }
    shift = of("transmission_error.1.phase") if 1 in pair.transmission_error else _one(Fraction(0))
    orders = sorted(pair.transmission_error)
    for order in orders:
        error = f"transmission_error.{order}"
        amplitude = _outwards(_over(_times(_one(Fraction(2)), of(f"{error}.amplitude")), reach))
        if order == 1:
            within["eccentricity"] = amplitude
            continue
        within[f"amplitude_{order}"] = amplitude
        within[f"phase_{order}"] = _phase(of(f"{error}.phase"), order, shift)
    middle = {name: min(max(0.5 * (low + high), low), high) for name, (low, high) in within.items()}
    harmonics = tuple(
        Harmonic(float(order), middle[f"amplitude_{order}"], middle[f"phase_{order}"]) for order in orders if order > 1
    )
    centre = Oscillator(
        middle["damping"], middle["eccentricity"], middle["half_backlash"],
        restitution=middle["restitution"], harmonics=harmonics,
    )  # fmt: skip
    return ParameterBox(centre, within, _outwards(_over(_times(wide, speed), _one(4 * _PI))))


def _drag_follows_speed(pair: GearPair, limits: Limits) -> bool:
    """Whether the drag torque changes with the speed: not if it is given after it, for then it is as given."""
    names = list(limits)
    if pair.drag_law != "proportional" or "speed" not in names:
        return False
    return "drag_torque" not in names or names.index("drag_torque") < names.index("speed")


def _restitution(pair: GearPair, limits: Limits) -> tuple[float, float]:
    if pair.restitution is not None:
        return limits.get("restitution", (pair.restitution, pair.restitution))
    if pair.contact_damping is None:
        return _EXACTLY_ONE
    least, most = limits.get("contact_damping", (pair.contact_damping, pair.contact_damping))
    low, high = _outwards(_Numbers(_kept(most), _kept(least)))
    return low, min(high, 1.0)


def _kept(contact_damping: float) -> Fraction:
    """What an impact keeps of the speed, r = exp(-pi zeta/sqrt(1 - zeta^2)): it falls with zeta."""
    with localcontext(prec=_DIGITS):
        zeta = Decimal(contact_damping)
        return Fraction((-Decimal(_PI_DIGITS) * zeta / (1 - zeta * zeta).sqrt()).exp())


def _phase(own: _Numbers, order: int, shift: _Numbers) -> tuple[float, float]:
    """Phase of an order, in periods of its own, once time begins where the first order has phase 0."""
    low, high = own.low - order * shift.high, own.high - order * shift.low
    if high - low >= 1:
        return 0.0, 1.0
    whole = math.floor((low + high) / 2)
    # They are rounded as parts of the largest number in them.
    largest = 1 + max(abs(own.low), abs(own.high)) + order * max(abs(shift.low), abs(shift.high))
    return _as_floats(low - whole - _OUTWARDS * largest, high - whole + _OUTWARDS * largest)


def _one(value: Fraction) -> _Numbers:
    return _Numbers(value, value)


def _times(*factors: _Numbers) -> _Numbers:
    """Product of numbers that are not negative."""
    one = Fraction(1)
    return _Numbers(
        math.prod((each.low for each in factors), start=one), math.prod((each.high for each in factors), start=one)
    )


def _over(a: _Numbers, b: _Numbers) -> _Numbers:
    """A / b, of numbers that are not negative."""
    return _Numbers(a.low / b.high, a.high / b.low)


def _outwards(a: _Numbers) -> tuple[float, float]:
    return _as_floats(a.low * (1 - _OUTWARDS), a.high * (1 + _OUTWARDS))


def _as_floats(low: Fraction, high: Fraction) -> tuple[float, float]:
    """The nearest floats that hold both: a fraction becomes the nearest float, which may lie on either side."""
    down, up = float(low), float(high)
    return (
        down if Fraction(down) <= low else math.nextafter(down, -math.inf),
        up if Fraction(up) >= high else math.nextafter(up, math.inf),
    )
