"""Periodic orbits and special points that a figure names, and their entries in the figure's JSON file."""

from typing import Any

from rattle_kernels import (
    Attractor,
    FoundOrbit,
    Oscillator,
    PeriodicOrbit,
    SpecialKind,
    SpecialPoint,
    continue_orbit,
    find_orbit,
    find_orbits,
)

# Enough to find the orbits that the paper names.
_SEARCH_CELLS = 24
# Windows are searched within this fraction of the damping.
_WINDOW = 0.02
_WINDOW_POINTS = 400


def orbits_named(oscillator: Oscillator, name: str) -> tuple[FoundOrbit, ...]:
    """All orbits with a name P(m, n+, n-) that the search finds, stable or not, the slowest first."""
    longest = int(name.removeprefix("P(").split(",")[1])
    return tuple(each for each in find_orbits(oscillator, longest, cells=_SEARCH_CELLS) if each.orbit.name == name)


def the_orbit(oscillator: Oscillator, name: str, *, attracts: bool) -> PeriodicOrbit:
    """The only orbit with a name that attracts, or the only one that does not."""
    (orbit,) = (each.orbit for each in orbits_named(oscillator, name) if each.orbit.attracts == attracts)
    return orbit


def the_point(points: tuple[SpecialPoint, ...], kind: SpecialKind) -> SpecialPoint:
    """The only special point of a kind."""
    (point,) = (each for each in points if each.kind == kind)
    return point


def orbit_summary(orbit: PeriodicOrbit) -> dict[str, Any]:
    """Name, departures and multipliers of an orbit, and the residual of P^p(x) = x."""
    return {
        "name": orbit.name,
        "attracts": orbit.attracts,
        "points": list(zip(orbit.t.tolist(), orbit.v.tolist(), strict=True)),
        "multipliers": [[each.real, each.imag] for each in orbit.multipliers.tolist()],
        "residual": orbit.residual,
    }


def point_summary(point: SpecialPoint) -> dict[str, Any]:
    """Kind, orbit, parameter value and departures of a special point, and the residual of its equations."""
    return {
        "kind": point.kind.value,
        "orbit": point.orbit_name,
        point.parameter: point.value,
        "points": list(zip(point.t.tolist(), point.v.tolist(), strict=True)),
        "residual": point.residual,
        "error": point.error,
    }


def window_summary(oscillator: Oscillator, attractor: Attractor) -> dict[str, Any]:
    """The nearest special points below and above in damping. A periodic attractor persists between them.

    Empty if Newton's method does not find the attractor again, which can happen close to a graze.
    """
    found = find_orbit(oscillator, attractor.time[0], attractor.velocity[0], attractor.upper_contacts)
    if found is None:
        return {}
    here = oscillator.damping
    bounds = (1.0 - _WINDOW) * here, (1.0 + _WINDOW) * here
    points = continue_orbit(oscillator, found.orbit, "damping", bounds, most_points=_WINDOW_POINTS).special_points
    below = max((point for point in points if point.value < here), key=lambda point: point.value, default=None)
    above = min((point for point in points if point.value > here), key=lambda point: point.value, default=None)
    return {
        side: {"kind": point.kind.value, "damping": point.value, "residual": point.residual}
        for side, point in (("below", below), ("above", above))
        if point is not None
    }
