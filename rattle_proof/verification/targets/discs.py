"""Discs: P^p maps each into itself and brings all its points nearer to each other, so they end in one periodic orbit.

The disc is covered by parts. If P^p maps each into the disc, and |DP^p| < 1 over each in the disc's coordinates, that
is so, by the mean value theorem (the disc is convex and compact) and Banach's. A disc is narrower than a period, so
that it does not meet its copies whole periods away, and its image, which is connected, lies in one of them.
"""

from flint import arb

from rattle_proof.verification.claims import Claims, Disc
from rattle_proof.verification.ends import in_disc, in_frame
from rattle_proof.verification.flight import Slope
from rattle_proof.verification.machine import UNIT, Machine
from rattle_proof.verification.moving import Moving, advance, box
from rattle_proof.verification.targets.quiet import halves, parts_of
from rattle_proof.verification.verdict import Failure, contradicted, undecided

_DEPTH = 18
# Of tolerances.
_PARTS = 8


def try_disc(claims: Claims, number: int) -> Failure | None:
    """Prove one of them again."""
    failures = (_disc(machine, claims.discs[number]) for machine in parts_of(claims.machine, _PARTS))
    return next((each for each in failures if each is not None), None)


def _disc(machine: Machine, disc: Disc) -> Failure | None:
    place = f"{disc.impacts} impacts, around t = {disc.t!r}, v = {disc.v!r}, radius {disc.radius:.6g}"
    inverse, radius = inverse_of(disc), arb(disc.radius)
    dt, dv = (radius * length(*row).upper() for row in ((inverse.tt, inverse.tv), (inverse.vt, inverse.vv)))
    if not 2 * dt < 1:
        return contradicted(place, "it is as wide as a period")
    return _of_part(machine, disc, inverse, arb(disc.t) + dt * UNIT, arb(disc.v) + dv * UNIT, _DEPTH, place)


def _of_part(machine: Machine, disc: Disc, inverse: Slope, t: arb, v: arb, depth: int, place: str) -> Failure | None:
    """Whether P^p maps the part of a disc in a box into the disc, with |DP^p| < 1."""
    if length(*in_frame(disc, t - arb(disc.t), v - arb(disc.v))) >= disc.radius:
        return None
    after = _after(machine, disc, box(t, v))
    if after is not None:
        moving, slope = after
        (a, b), (c, d) = disc.frame
        norm = norm_of(Slope(arb(a), arb(b), arb(c), arb(d)).times(slope).times(inverse))
        if norm < 1 and in_disc(disc, moving):
            return None
        if norm >= 1:
            return contradicted(place, f"DP^{disc.impacts} does not contract near t = {t.mid()}, v = {v.mid()}")
    if depth == 0:
        return undecided(place, f"P^{disc.impacts} may leave it or not contract near t = {t.mid()}, v = {v.mid()}")
    parts = ((half, v) for half in halves(t)) if depth % 2 else ((t, half) for half in halves(v))
    for part in parts:
        failure = _of_part(machine, disc, inverse, *part, depth - 1, place)
        if failure is not None:
            return failure
    return None


def _after(machine: Machine, disc: Disc, moving: Moving) -> tuple[Moving, Slope] | None:
    """A set under P^p, and DP^p over it."""
    slope = Slope(arb(1), arb(0), arb(0), arb(1))
    for _ in range(disc.impacts):
        advanced = advance(machine, moving)
        if advanced is None or advanced[1].slope is None:
            return None
        slope, moving = advanced[1].slope.times(slope), advanced[0]
    return moving, slope


def inverse_of(disc: Disc) -> Slope:
    """The inverse of a disc's frame."""
    (a, b), (c, d) = ((arb(each) for each in row) for row in disc.frame)
    size = a * d - b * c
    return Slope(d / size, -b / size, -c / size, a / size)


def length(x: arb, y: arb) -> arb:
    """Of a difference in a disc's coordinates."""
    return (x * x + y * y).sqrt()


def norm_of(m: Slope) -> arb:
    """The larger singular value."""
    squares = m.tt * m.tt + m.tv * m.tv + m.vt * m.vt + m.vv * m.vv
    determinant = m.tt * m.vv - m.tv * m.vt
    gap = (squares * squares - 4 * determinant * determinant).nonnegative_part().sqrt()
    return ((squares + gap) / 2).sqrt()
