"""Sets of departures that move under P: parallelograms ``c + A [-1, 1]^2`` and a small rest, in Arb balls."""

from typing import NamedTuple

from flint import arb

from rattle_proof.verification.flight import Slope
from rattle_proof.verification.impact import Image, image
from rattle_proof.verification.machine import UNIT, Machine, within

WIDEST = 0.4
"""Width in time beyond which a set is given up."""
_STEEPEST = 1e6


class Strip(NamedTuple):
    """Times and speeds of a set, and a ball of ``v - slope t``."""

    t: arb
    v: arb
    slope: arb
    offset: arb


class Moving(NamedTuple):
    """A set of departures.

    ``t, v`` is its middle; ``sides`` are (time, speed) of the two half sides; ``rest_t, rest_v`` hold what else there
    is; ``all_t, all_v`` hold all of it. Numbers of the first two are exact.
    """

    t: arb
    v: arb
    sides: tuple[tuple[arb, arb], tuple[arb, arb]]
    rest_t: arb
    rest_v: arb
    all_t: arb
    all_v: arb

    @property
    def strip(self) -> Strip:
        """The strip along the longer side that holds the set."""
        along_t, along_v = max(self.sides, key=lambda side: abs(float(side[0])))
        steep = abs(float(along_t)) * _STEEPEST <= abs(float(along_v))
        slope = arb(0) if steep else (along_v / along_t).mid()
        offset = self.v - slope * self.t + self.rest_v - slope * self.rest_t
        for side_t, side_v in self.sides:
            offset += (side_v - slope * side_t) * UNIT
        return Strip(self.all_t, self.all_v, slope, offset)


def box(t: arb, v: arb) -> Moving:
    """All departures of two balls."""
    zero = arb(0)
    return Moving(t.mid(), v.mid(), ((t.rad(), zero), (zero, v.rad())), zero, zero, t, v)


def advance(machine: Machine, moving: Moving) -> tuple[Moving, Image] | None:
    """Image of a set under P, and what P was there; None where nothing is proven."""
    mapped = image(machine, moving.t, moving.v, moving.all_t, moving.all_v)
    if mapped is None or not mapped.all_t.rad() < WIDEST / 2:
        return None
    if mapped.slope is None:
        return _without_turns(box(mapped.all_t, mapped.all_v)), mapped
    return carried(moving, mapped, mapped.slope), mapped


def carried(moving: Moving, mapped: Image, slope: Slope) -> Moving:
    """Image of a set, by the slope over it, whole periods aside."""
    t, v = mapped.t.mid(), mapped.v.mid()
    sides, rest = [], slope.of(moving.rest_t, moving.rest_v)
    rest_t, rest_v = rest[0] + (mapped.t - t), rest[1] + (mapped.v - v)
    all_t, all_v = t, v
    for side in moving.sides:
        moved_t, moved_v = slope.of(*side)
        side_t, side_v = moved_t.mid(), moved_v.mid()
        rest_t += (moved_t - side_t) * UNIT
        rest_v += (moved_v - side_v) * UNIT
        all_t, all_v = all_t + side_t * UNIT, all_v + side_v * UNIT
        sides.append((side_t, side_v))
    # The middle belongs to it: slopes of the next image are taken between the middle and all else.
    all_t, all_v = within(all_t + rest_t, mapped.all_t).union(t), within(all_v + rest_v, mapped.all_v).union(v)
    return _without_turns(Moving(t, v, (sides[0], sides[1]), rest_t, rest_v, all_t, all_v))


def _without_turns(moving: Moving) -> Moving:
    turns = moving.t.floor()
    return moving._replace(t=moving.t - turns, all_t=moving.all_t - turns)
