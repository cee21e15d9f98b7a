"""Discs: P^p maps each into itself and brings all its points nearer to each other, so they end in one periodic orbit.

In the disc's coordinates |DP^p| <= q over the disc, and its middle moves by at most d. If q < 1 and ``q radius + d <
radius``, that is so, by the mean value theorem (the disc is convex) and Banach's. The bound on DP^p may be sought in
parts of the disc: it holds along every chord that crosses them.
"""

from flint import arb

from rattle.verification.claims import Claims, Disc
from rattle.verification.ends import in_frame
from rattle.verification.flight import Slope
from rattle.verification.machine import UNIT, Machine
from rattle.verification.moving import Moving, advance, box
from rattle.verification.quiet import halves
from rattle.verification.verdict import Failure, Part, contradicted, undecided

_DEPTH = 12


def discs(claims: Claims) -> Part:
    """Prove all of them again."""
    part = Part("discs around periodic orbits", len(claims.discs))
    for disc in claims.discs:
        failure = _disc(claims.machine, disc)
        part.add(1, [] if failure is None else [failure])
    return part


def _disc(machine: Machine, disc: Disc) -> Failure | None:
    place = f"{disc.impacts} impacts, around t = {disc.t!r}, v = {disc.v!r}, radius {disc.radius:.6g}"
    t, v = arb(disc.t), arb(disc.v)
    moving = _image(machine, disc, box(t, v))
    if moving is None:
        return undecided(place, "the image of its middle cannot be enclosed")
    off = moving.all_t - t
    moved = _length(*in_frame(disc, off - (off + 0.5).floor().mid(), moving.all_v - v))
    radius = arb(disc.radius)
    if moved >= radius:
        return contradicted(place, "the image of its middle lies outside")
    allowed = ((radius - moved) / radius).lower()
    inverse = _inverse(disc)
    dt, dv = (radius * _length(*row).upper() for row in ((inverse.tt, inverse.tv), (inverse.vt, inverse.vv)))
    return _nearer(machine, disc, inverse, t + dt * UNIT, v + dv * UNIT, allowed, _DEPTH, place)


def _nearer(
    machine: Machine, disc: Disc, inverse: Slope, t: arb, v: arb, allowed: arb, depth: int, place: str
) -> Failure | None:
    """Whether |DP^p| stays below a bound on the part of a disc in a box."""
    if _length(*in_frame(disc, t - arb(disc.t), v - arb(disc.v))) >= disc.radius:
        return None
    slope = _slope(machine, disc, box(t, v))
    if slope is not None:
        (a, b), (c, d) = disc.frame
        norm = _norm(Slope(arb(a), arb(b), arb(c), arb(d)).times(slope).times(inverse))
        if norm < allowed:
            return None
        if norm >= allowed and norm >= 1:
            return contradicted(place, f"DP^{disc.impacts} does not contract near t = {t.mid()}, v = {v.mid()}")
    if depth == 0:
        return undecided(place, f"no bound on DP^{disc.impacts} near t = {t.mid()}, v = {v.mid()}")
    parts = ((half, v) for half in halves(t)) if depth % 2 else ((t, half) for half in halves(v))
    for part in parts:
        failure = _nearer(machine, disc, inverse, *part, allowed, depth - 1, place)
        if failure is not None:
            return failure
    return None


def _image(machine: Machine, disc: Disc, moving: Moving) -> Moving | None:
    for _ in range(disc.impacts):
        advanced = advance(machine, moving)
        if advanced is None:
            return None
        moving = advanced[0]
    return moving


def _slope(machine: Machine, disc: Disc, moving: Moving) -> Slope | None:
    """DP^p over a set."""
    slope = Slope(arb(1), arb(0), arb(0), arb(1))
    for _ in range(disc.impacts):
        advanced = advance(machine, moving)
        if advanced is None or advanced[1].slope is None:
            return None
        slope, moving = advanced[1].slope.times(slope), advanced[0]
    return slope


def _inverse(disc: Disc) -> Slope:
    (a, b), (c, d) = ((arb(each) for each in row) for row in disc.frame)
    size = a * d - b * c
    return Slope(d / size, -b / size, -c / size, a / size)


def _length(x: arb, y: arb) -> arb:
    return (x * x + y * y).sqrt()


def _norm(m: Slope) -> arb:
    """The larger singular value."""
    squares = m.tt * m.tt + m.tv * m.tv + m.vt * m.vt + m.vv * m.vv
    determinant = m.tt * m.vv - m.tv * m.vt
    gap = (squares * squares - 4 * determinant * determinant).nonnegative_part().sqrt()
    return ((squares + gap) / 2).sqrt()
