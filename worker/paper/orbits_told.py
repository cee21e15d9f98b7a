"""Periodic orbits and special points: those that a figure names, and as the figures' JSON files hold them."""

from typing import Any

from rattle_kernels import FoundOrbit, Oscillator, PeriodicOrbit, SpecialPoint, find_orbits
from rattle_kernels.special_point import SpecialKind

_SEARCH_CELLS = 40


def orbits_named(oscillator: Oscillator, name: str) -> tuple[FoundOrbit, ...]:
    """All orbits P(m, n+, n-) of a name that the search finds, stable or not, the slowest first."""
    longest = int(name.removeprefix("P(").split(",")[1])
    return tuple(each for each in find_orbits(oscillator, longest, cells=_SEARCH_CELLS) if each.orbit.name == name)


def the_orbit(oscillator: Oscillator, name: str, *, attracts: bool) -> PeriodicOrbit:
    """The one orbit of a name that attracts, or that does not."""
    (orbit,) = (each.orbit for each in orbits_named(oscillator, name) if each.orbit.attracts == attracts)
    return orbit


def the_point(points: tuple[SpecialPoint, ...], kind: SpecialKind) -> SpecialPoint:
    """The one special point of a kind."""
    (point,) = (each for each in points if each.kind == kind)
    return point


def told_orbit(orbit: PeriodicOrbit) -> dict[str, Any]:
    """Departures, multipliers, and what is left of P^p(x) = x."""
    return {
        "name": orbit.name,
        "attracts": orbit.attracts,
        "points": list(zip(orbit.t.tolist(), orbit.v.tolist(), strict=True)),
        "multipliers": [[each.real, each.imag] for each in orbit.multipliers.tolist()],
        "residual": orbit.residual,
    }


def told_point(point: SpecialPoint) -> dict[str, Any]:
    """Kind, parameter and place of a special point, and what is left of its equations."""
    return {
        "kind": point.kind.value,
        "orbit": f"P({point.forcing_periods},{point.upper_contacts},{point.lower_contacts})",
        point.parameter: point.value,
        "points": list(zip(point.t.tolist(), point.v.tolist(), strict=True)),
        "residual": point.residual,
        "error": point.error,
    }
