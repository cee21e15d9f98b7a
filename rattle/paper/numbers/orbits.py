"""Periodic orbits and special points: those that a figure names, and as the figures' JSON files hold them."""

from typing import Any

from rattle_kernels import (
    Attractor,
    FoundOrbit,
    Oscillator,
    PeriodicOrbit,
    SpecialKind,
    SpecialPoint,
    continue_orbit,
    find_orbits,
    grazing_velocity,
)
from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit

# Enough for the orbits that the paper names.
_SEARCH_CELLS = 24
# Windows are looked for within this part of the damping.
_WINDOW = 0.02
_WINDOW_POINTS = 400


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


def told_window(oscillator: Oscillator, attractor: Attractor) -> dict[str, Any]:
    """Special points next below and next above in damping, between which a periodic attractor goes on as it is.

    Empty where Newton's method does not find it again, as may be next to a graze.
    """
    orbit = find_periodic_orbit(
        oscillator, float(attractor.time[0]), float(attractor.velocity[0]), attractor.upper_contacts,
        float(grazing_velocity(oscillator, 0.0)),
    )  # fmt: skip
    if orbit is None:
        return {}
    here = oscillator.damping
    bounds = (1.0 - _WINDOW) * here, (1.0 + _WINDOW) * here
    points = continue_orbit(oscillator, orbit, "damping", bounds, most_points=_WINDOW_POINTS).special_points
    below = max((point for point in points if point.value < here), key=lambda point: point.value, default=None)
    above = min((point for point in points if point.value > here), key=lambda point: point.value, default=None)
    return {
        side: {"kind": point.kind.value, "damping": point.value, "residual": point.residual}
        for side, point in (("below", below), ("above", above))
        if point is not None
    }
