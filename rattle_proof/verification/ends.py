"""In which end all departures of a set are claimed to come: boxes of a lattice, the core, discs."""

from collections.abc import Iterator

from flint import arb

from rattle_proof.verification.claims import RATTLES, Claims, Core, Disc, Lattice
from rattle_proof.verification.machine import Machine, ball
from rattle_proof.verification.moving import Moving, Strip

NOWHERE = 0
"""No end. Ends are 1 + the number of a motion."""
NEVER_QUIET = -1
"""Any end but that of what falls quiet, or none at all."""

Index = tuple[slice, int]
"""Rows of boxes in a column."""


def floor_of(a: arb) -> int:
    """The largest whole number that is not above any of a ball."""
    number = a.lower().floor().unique_fmpz()
    if number is None:
        raise ArithmeticError(f"no number of digits tells the floor of {a}")
    return int(number)


def boxes_of(lattice: Lattice, strip: Strip) -> Iterator[Index | None]:
    """Index of the boxes that a strip touches, column by column; None for a column where it leaves the lattice."""
    rows, held = lattice.ends.shape
    columns, height = lattice.columns, arb(lattice.height)
    for j in range(floor_of(strip.t * columns), floor_of((strip.t * columns).upper()) + 1):
        column = ball(j, j + 1) / columns
        times = column.intersection(strip.t)
        speeds = strip.slope * times + strip.offset
        if not speeds.overlaps(strip.v):
            continue
        lines = speeds.intersection(strip.v) / height
        bottom, top = floor_of(lines) - lattice.first, floor_of(lines.upper()) - lattice.first
        at = (j - lattice.left) % columns
        yield (slice(bottom, top + 1), at) if 0 <= bottom and top < rows and at < held else None


def end_in(lattice: Lattice, strip: Strip, before: int | None = None) -> int:
    """The one end of all boxes that a strip touches, proven `before` some round; else NOWHERE."""
    end = NOWHERE
    for boxes in boxes_of(lattice, strip):
        if boxes is None:
            return NOWHERE
        ends = lattice.ends[boxes]
        if end == NOWHERE:
            end = int(ends[0])
        if end == NOWHERE or (ends != end).any():
            return NOWHERE
        if before is not None and (lattice.rounds[boxes] >= before).any():
            return NOWHERE
    return end


def box_of(lattice: Lattice, row: int, column: int) -> tuple[arb, arb]:
    """Times and speeds of a box."""
    low, early = lattice.first + row, lattice.left + column
    return ball(early, early + 1) / lattice.columns, ball(low, low + 1) * arb(lattice.height)


class Ends:
    """The ends of sets.

    Parameters
    ----------
    claims : Claims
    """

    def __init__(self, claims: Claims) -> None:
        self.claims, self.machine = claims, claims.machine

    def of(self, moving: Moving, before: int | None = None) -> int:
        """The end that all of a set is claimed to come to, if by the lattice by boxes proven `before` a round."""
        return end_in(self.claims.lattice, moving.strip, before) or self.at_target(moving)

    def quiet_or_not(self, moving: Moving) -> int:
        """The end of what falls quiet, or NEVER_QUIET, if one of both is claimed of all of a set."""
        end = self.of(moving)
        if end == NOWHERE and (end_in(self.claims.never_quiet, moving.strip) or self._in_rattling_set(moving)):
            end = NEVER_QUIET
        return end if end in (NOWHERE, self.claims.quiet) else NEVER_QUIET

    def at_target(self, moving: Moving) -> int:
        """The motion whose core, disc, window or rattling set holds all of a set."""
        core = self.claims.core
        if core is not None and in_core(self.machine, core, moving.all_t, moving.all_v):
            return 1 + core.motion
        end = self.near_orbit(moving)
        if end == NOWHERE:
            end = self._in_rattling_set(moving)
        return NOWHERE if end == RATTLES else end

    def near_orbit(self, moving: Moving, before: int | None = None) -> int:
        """The motion whose disc holds all of a set, or boxes of a window, proven `before` some number."""
        for disc in self.claims.discs:
            if in_disc(disc, moving):
                return 1 + disc.motion
        # To leave a window out is no fault, so rounding does not matter here.
        speed = float(moving.strip.v.mid())
        for window in self.claims.windows:
            if 0.0 <= speed / window.height - window.first < window.ends.shape[0]:
                end = end_in(window, moving.strip, before)
                if end != NOWHERE:
                    return end
        return NOWHERE

    def _in_rattling_set(self, moving: Moving) -> int:
        return NOWHERE if self.claims.rattling is None else end_in(self.claims.rattling, moving.strip)


def in_core(machine: Machine, core: Core, t: arb, v: arb) -> bool:
    """Whether all departures of a box lie within the quiet core."""
    return bool(v**3 < core.level * machine.acceleration(t))


def in_disc(disc: Disc, moving: Moving) -> bool:
    """Whether all of a set lies within a disc."""
    off = moving.t - arb(disc.t)
    off -= (off + 0.5).floor().mid()
    middle = in_frame(disc, off + moving.rest_t, moving.v - arb(disc.v) + moving.rest_v)
    square = arb(disc.radius) ** 2
    if not _square(*middle) < square:
        return False
    sides = [in_frame(disc, *side) for side in moving.sides]
    # The corners of a parallelogram are the furthest.
    corners = (tuple(m + sign_a * a + sign_b * b for m, a, b in zip(middle, *sides, strict=True))
               for sign_a in (-1, 1) for sign_b in (-1, 1))  # fmt: skip
    return all(_square(*corner) < square for corner in corners)


def _square(x: arb, y: arb) -> arb:
    return x * x + y * y


def in_frame(disc: Disc, dt: arb, dv: arb) -> tuple[arb, arb]:
    """A difference in a disc's coordinates."""
    (a, b), (c, d) = disc.frame
    return arb(a) * dt + arb(b) * dv, arb(c) * dt + arb(d) * dv
