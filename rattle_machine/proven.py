"""How fast teeth may part in any machine of a production and fall quiet for certain: proven, by `rattle_proof`.

Limits of numbers become a box of parameters (`parameter_box`), and all oscillators of a box have a quiet core: whatever
departs with ``v^3 < level a(t)`` falls quiet. The least a(t) of all its oscillators and phases makes a speed of it, and
the least unit of speed of all its machines one in m/s.

What differs from machine to machine blurs what is proven of them together. So the limits are cut, always those of the
part whose speed is the least, for that is the speed of all.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from decimal import ROUND_FLOOR, Context
from functools import partial
from importlib.util import find_spec

from rattle_kernels import OutsideDomain, check_domain
from rattle_kernels.numerics.pausing import Pause, never_stopped
from rattle_machine.numbers import with_number
from rattle_machine.parameter_box import Limits, parameter_box
from worker.gear_pair import GearPair
from worker.precision_limits import fastest_of

PARTS = 16
"""Into how many parts limits are cut at most."""
_DIGITS = 4
# What a cube root is taken below what was rounded, for its cube to lie below.
_BELOW = 1.0 - 2.0**-40
# Numbers with which inertia torque grows beside drag torque; with the others that change both it falls.
_GROWS_WITH = ("speed", "inertia", "amplitude")
_FALLS_WITH = ("drag_torque", "base_radius", "inertia_ratio")


@dataclass(frozen=True)
class Proven:
    """What is proven of every machine of a production, or why nothing is.

    Attributes
    ----------
    speed : float or None
        Teeth that part with less, in m/s, fall quiet, at any moment and in every machine. Rounded down to four digits.
    model_speed : float or None
        So in the model, whose unit is not the same in each machine.
    reason : str or None
        Why nothing could be proven.
    tightened : bool
        Whether it is said of the production whose guilty tolerance is tightened.
    """

    speed: float | None
    model_speed: float | None
    reason: str | None
    tightened: bool = False

    def __str__(self) -> str:
        """One sentence."""
        machines = "In every machine of the " + ("tightened production" if self.tightened else "production")
        if self.speed is None:
            return f"{machines}, that slow teeth fall quiet could not be proven: {self.reason}."
        return (
            f"{machines}, teeth that part with less than {self.speed:g} m/s at any moment fall quiet: that is proven."
        )


@dataclass(frozen=True)
class _Part:
    """Limits, and the speed below which all of their machines fall quiet, in m/s and in the model; 0 if none does."""

    limits: Limits
    speed: float
    model_speed: float
    meets_eq_8: bool = True


Mapper = Callable[[Callable[[Limits], _Part], Iterable[Limits]], Iterator[_Part]]


def can_prove() -> bool:
    """Whether what proves is installed."""
    return find_spec("rattle_proof") is not None


def prove_quiet(
    pair: GearPair, limits: Limits, *, fastest: float | None = None, tightened: bool = False, mapper: Mapper = map,
    pause: Pause = never_stopped,
) -> Proven:  # fmt: skip
    """Prove for all machines within limits how fast teeth may part and fall quiet.

    Parameters
    ----------
    pair : GearPair
        With the numbers that have no limits.
    limits : mapping
    fastest : float, optional
        Speed in m/s beyond which nothing is sought; by default the upper end of the window of the machine in the
        middle.
    tightened : bool
        What the answer says of itself.
    mapper : callable
        As `map`; that of an executor proves parts in its threads.
    pause : callable
        Called several times a second; an exception raised there ends the proof.

    Returns
    -------
    Proven
    """
    if pair.mesh_stiffness is not None:
        return Proven(None, None, "it is proven of impacts alone, so without a mesh stiffness", tightened)
    for machine in _suspects(pair, limits):
        if machine.gamma >= 1.0:
            why = f"inertia torque reaches drag torque in some of them (Gamma is {machine.gamma:.4g}), and teeth part "
            return Proven(None, None, f"{why}in every turn", tightened)
    middle = _machine_with(pair, {name: 0.5 * (low + high) for name, (low, high) in limits.items()})
    top = fastest or fastest_of(check_domain(middle.oscillator)) * middle.scales.speed
    parts = _cut(pair, limits, partial(_proven_part, pair, top, pause), top, mapper)
    least = min(part.speed for part in parts)
    if least > 0.0:
        model_speed = min(part.model_speed for part in parts)
        return Proven(_rounded_down(least), _rounded_down(model_speed), None, tightened)
    if all(part.meets_eq_8 for part in parts):
        why = "the machines differ too much for their bounces to be seen to become lower together"
    else:
        why = "it was not seen that drag torque exceeds inertia torque in all of them (Eq. 8)"
    return Proven(None, None, f"{why}; narrower tolerances may be proven", tightened)


def _machine_with(pair: GearPair, values: dict[str, float]) -> GearPair:
    for name, value in values.items():
        pair = with_number(pair, name, value)
    return pair


def _suspects(pair: GearPair, limits: Limits) -> Iterator[GearPair]:
    """Machines within limits whose inertia torque is large beside their drag torque, phases as they may be."""
    for part in (0.5, 0.0, 1.0):
        values = {name: (1.0 - part) * low + part * high for name, (low, high) in limits.items()}
        if part == 0.5:
            yield _machine_with(pair, values)
        values |= {name: high for name, (_, high) in limits.items() if name.endswith(_GROWS_WITH)}
        values |= {name: low for name, (low, _) in limits.items() if name in _FALLS_WITH}
        yield _machine_with(pair, values)


def _cut(
    pair: GearPair, limits: Limits, prove: Callable[[Limits], _Part], top: float, mapper: Mapper
) -> list[_Part]:  # fmt: skip
    """Parts of limits, that of the least speed cut again and again."""
    parts = [prove(limits)]
    while len(parts) < PARTS:
        least = min(parts, key=lambda part: part.speed)
        halves = _halves(pair, least.limits)
        if not halves or least.speed >= top:
            break
        parts.remove(least)
        parts += mapper(prove, halves)
    return parts


def _proven_part(pair: GearPair, top: float, pause: Pause, limits: Limits) -> _Part:
    from rattle_proof.enclosures.interval import down
    from rattle_proof.enclosures.machine import machine_of
    from rattle_proof.enclosures.quiet_core import level_of

    box = parameter_box(pair, limits)
    unit = box.speed[0]
    try:
        machine = machine_of(box.oscillator, box.within)
    except OutsideDomain:
        return _Part(limits, 0.0, 0.0, meets_eq_8=False)
    level = level_of(machine, top / unit, pause)
    speed = _root_below(down(level * machine.least_acceleration))
    return _Part(limits, down(speed * unit), speed)


def _root_below(cube: float) -> float:
    """A number whose cube is smaller; 0 if there is none above."""
    from rattle_proof.enclosures.interval import up

    root = _BELOW * math.cbrt(max(cube, 0.0))
    return root if up(up(root * root) * root) < cube else 0.0


def _rounded_down(value: float) -> float:
    return float(Context(prec=_DIGITS, rounding=ROUND_FLOOR).create_decimal(value))


def _halves(pair: GearPair, limits: Limits) -> list[Limits]:
    """Cut that number in two which blurs the action v^3/a(t) most; none if nothing does."""
    blur = {name: _blur(pair, limits, name) for name in limits}
    widest = max(blur, key=lambda name: blur[name], default="")
    if not blur or blur[widest] == 0.0:
        return []
    low, high = limits[widest]
    middle = 0.5 * (low + high)
    return [{**limits, widest: half} for half in ((low, middle), (middle, high))]


def _blur(pair: GearPair, limits: Limits, name: str) -> float:
    """How far v^3/a(t) differs by one number alone, as a part of itself."""
    middles = {other: (0.5 * (low + high),) * 2 for other, (low, high) in limits.items()}
    box = parameter_box(pair, {**middles, name: limits[name]})

    def part(ends: tuple[float, float]) -> float:
        return (ends[1] - ends[0]) / ends[1]

    total = 3.0 * part(box.speed) + part(box.within["damping"])
    for order, amplitude, _ in box.oscillator.all_harmonics:
        names = ("eccentricity", "") if order == 1.0 else (f"amplitude_{order:g}", f"phase_{order:g}")
        # Of the acceleration at rest, 4 pi delta on average.
        bend = (2.0 * math.pi * order) ** 2 / (4.0 * math.pi * box.oscillator.damping)
        low, high = box.within[names[0]]
        early, late = box.within.get(names[1], (0.0, 0.0))
        total += bend * ((high - low) + amplitude * 2.0 * math.pi * (late - early))
    return total
