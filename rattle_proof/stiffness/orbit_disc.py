"""Discs around periodic orbits of the piecewise linear model: P^p maps each into itself and contracts it.

The disc ``|F (x - c)| <= radius`` is covered by squares in the coordinates F (x - c). Over each ``F DP^p F^-1`` is
proven to have a norm of at most g < 1. The disc is convex, so P^p brings its points closer by g. If it moves c by less
than ``(1 - g) radius``, it maps the disc into itself: which holds just one periodic orbit then, to which all its
departures come (Banach).
"""

from typing import NamedTuple

from flint import arb

from rattle_kernels import PeriodicOrbit
from rattle_proof.stiffness.contact import StiffMachine
from rattle_proof.stiffness.impact_map import NotProven, passage
from rattle_proof.verification.claims import Disc
from rattle_proof.verification.ends import in_frame
from rattle_proof.verification.flight import Slope
from rattle_proof.verification.impact import Way
from rattle_proof.verification.machine import UNIT
from rattle_proof.verification.moving import Moving, carried
from rattle_proof.verification.targets.discs import inverse_of, length, norm_of

# Radii that are tried: the least, and by what they grow while they are proven.
_LEAST, _GROWS, _LARGEST = 2.0**-32, 2.0**0.5, 0.25
# How often squares are cut into four.
_CUTS = 3
_IDENTITY = Slope(arb(1), arb(0), arb(0), arb(1))


class ProvenDisc(NamedTuple):
    """A disc, the factor by which P^p brings its points closer at least, and what is true of all its departures.

    ``periods`` is how long the orbit's turn takes, with so many ``lower_contacts``. ``slowest`` is a bound below the
    speeds at which motions cross a wall in a turn. ``apart`` is how far at most the periodic point is from the middle
    of the disc, in its coordinates.
    """

    disc: Disc
    contraction: float
    periods: int
    lower_contacts: int
    slowest: float
    apart: float


def largest_disc(
    machine: StiffMachine, orbit: PeriodicOrbit, place: int, frame: tuple[tuple[float, float], tuple[float, float]]
) -> ProvenDisc:
    """The largest disc that is proven around a departure of an orbit, of those that are tried.

    Parameters
    ----------
    machine : StiffMachine
        a(t) > 0.
    orbit : PeriodicOrbit
        As numbers have it. Nothing rests on them.
    place : int
        Of the departure.
    frame : ((float, float), (float, float))
        F.

    Returns
    -------
    ProvenDisc

    Raises
    ------
    NotProven
        Why not even the smallest disc is proven.
    """
    disc = Disc(0, orbit.upper_contacts, float(orbit.t[place]), float(orbit.v[place]), frame, _LEAST)
    found = prove_disc(machine, disc)
    while found.disc.radius < _LARGEST:
        try:
            found = prove_disc(machine, disc._replace(radius=_GROWS * found.disc.radius))
        except NotProven:
            break
    return found


def prove_disc(machine: StiffMachine, disc: Disc) -> ProvenDisc:
    """Prove that P^p maps a disc into itself and contracts it.

    Raises
    ------
    NotProven
        Why not.
    """
    inverse = inverse_of(disc)
    radius = arb(disc.radius)
    if not 2 * radius * length(inverse.tt, inverse.tv) < 1:
        raise NotProven("it is as wide as a period")
    contraction, slowest, ways = arb(0), arb.pos_inf(), None
    waiting = [(arb(0), arb(0), radius, 0)]
    while waiting:
        x, y, half, cuts = waiting.pop()
        if length(x + half * UNIT, y + half * UNIT) > radius:
            continue  # beside the disc
        try:
            part = _after(machine, disc, _square(disc, inverse, x, y, half))
            factor = norm_of(_in_frame(disc, part.slope, inverse)).upper()
            if not factor < 1:
                raise NotProven("it does not contract")
        except NotProven:
            if cuts == _CUTS:
                raise
            quarter = half / 2
            waiting += [(x + a * quarter, y + b * quarter, quarter, cuts + 1) for a in (-1, 1) for b in (-1, 1)]
            continue
        if ways is not None and part.ways != ways:
            raise NotProven("it meets the grazing curve")
        ways = part.ways
        contraction, slowest = contraction.max(factor), slowest.min(part.slowest)
    middle = _after(machine, disc, _square(disc, inverse, arb(0), arb(0), arb(0)))
    periods = (middle.elapsed + 0.5).floor().unique_fmpz()
    if periods is None:
        raise NotProven("its images leave it")
    off = middle.elapsed - periods, middle.moving.all_v - arb(disc.v)
    apart = length(*in_frame(disc, *off)) / (1 - contraction)
    if not apart < radius:
        raise NotProven("its images leave it")
    lower = middle.ways.count(Way.LOWER)
    return ProvenDisc(disc, _above(contraction), int(periods), lower, -_above(-slowest), _above(apart))


class _Part(NamedTuple):
    """A set after a turn, DP^p over it, how long its middle took, and how it went."""

    moving: Moving
    slope: Slope
    elapsed: arb
    ways: tuple[Way, ...]
    slowest: arb


def _square(disc: Disc, inverse: Slope, x: arb, y: arb, half: arb) -> Moving:
    """The departures of a square of the disc's coordinates, with those that rounding adds."""
    off_t, off_v = inverse.of(x, y)
    t, v = (arb(disc.t) + off_t).mid(), (arb(disc.v) + off_v).mid()
    rest_t, rest_v = arb(disc.t) + off_t - t, arb(disc.v) + off_v - v
    sides = []
    all_t, all_v = t + rest_t, v + rest_v
    for side_t, side_v in ((half * inverse.tt, half * inverse.vt), (half * inverse.tv, half * inverse.vv)):
        all_t, all_v = all_t + side_t * UNIT, all_v + side_v * UNIT
        rest_t, rest_v = rest_t + (side_t - side_t.mid()) * UNIT, rest_v + (side_v - side_v.mid()) * UNIT
        sides.append((side_t.mid(), side_v.mid()))
    return Moving(t, v, (sides[0], sides[1]), rest_t, rest_v, all_t.union(t), all_v.union(v))


def _after(machine: StiffMachine, disc: Disc, moving: Moving) -> _Part:
    """A set under P^p, DP^p over it, and how it went."""
    slope, slowest, elapsed = _IDENTITY, arb.pos_inf(), arb(0)
    ways: list[Way] = []
    for _ in range(disc.impacts):
        passed = passage(machine, moving.t, moving.v, moving.all_t, moving.all_v)
        one = passed.image.slope
        if one is None or not passed.image.all_t.rad() < 0.5:
            raise NotProven("its images spread")
        elapsed += passed.image.all_t - moving.all_t
        slope, moving = one.times(slope), carried(moving, passed.image, one)
        ways.append(passed.image.way)
        slowest = slowest.min(passed.slowest)
    return _Part(moving, slope, elapsed, tuple(ways), slowest)


def _in_frame(disc: Disc, slope: Slope, inverse: Slope) -> Slope:
    (a, b), (c, d) = disc.frame
    return Slope(arb(a), arb(b), arb(c), arb(d)).times(slope).times(inverse)


def _above(number: arb) -> float:
    """A double that is not below a ball."""
    upper = float(number.upper())
    return upper + abs(upper) * 2.0**-50
