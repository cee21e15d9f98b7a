"""P of the piecewise linear model in ball arithmetic, for any forcing and damping in contact: digits that are proven.

Every number is a ball that holds the exact value (Arb, by python-flint). The motion is written in its plainest form,
a sum of exponentials and cosines, of which the kernels' formulas share nothing: what cancels is paid for in digits. The
first crossing of a wall is proven: time is cut into pieces, and on each piece the distance from the wall is shown to
stay positive, or to fall all the way to its one zero.

``python -m tests.rattle_kernels.impact_map.balls`` writes the table ``data/map_contacts.json``.
"""

import json
import random
from pathlib import Path
from typing import NamedTuple

from flint import acb, arb, ctx

from rattle_kernels import Oscillator, grazing_velocity

TABLE = Path(__file__).parents[1] / "data" / "map_contacts.json"
_BITS = 300
_DIGITS = 40
_ENTRIES = 120
_NEWTON_STEPS = 40
_LONGEST = 1000
_LONGEST_PIECE, _SHORTEST_PIECE = arb(2) ** -5, arb(2) ** -80
_STAYS, _ENDS = "stays", "ends"


class Wave(NamedTuple):
    """One term of a motion: the real part of ``size exp(rate tau)``, tau from the motion's beginning."""

    size: acb
    rate: acb


class Motion(NamedTuple):
    """A motion ``level + slope tau + waves``."""

    level: arb
    slope: arb
    waves: tuple

    def position(self, tau):
        return self.level + self.slope * tau + sum((wave.size * (wave.rate * tau).exp()).real for wave in self.waves)

    def velocity(self, tau):
        return self.slope + sum((wave.size * wave.rate * (wave.rate * tau).exp()).real for wave in self.waves)


def _waves(oscillator, time, answer):
    """The forcing's harmonics from a time on, each times the complex number by which the motion answers its rate."""
    waves = []
    for order, amplitude, phase in ((1.0, oscillator.eccentricity, 0.0), *oscillator.harmonics):
        rate = acb(0, 2 * arb.pi() * arb(order))
        turn = acb(0, 2 * arb.pi() * (arb(order) * time + arb(phase))).exp()
        waves.append(Wave(arb(amplitude) * turn * answer(rate), rate))
    return waves


def _freeplay(oscillator, time, position, velocity):
    delta, mean = arb(oscillator.damping), 4 * arb.pi()
    forced = _waves(oscillator, time, lambda rate: acb(1))
    fades = (mean + sum((wave.size * wave.rate).real for wave in forced) - velocity) / delta
    start = fades + sum(wave.size.real for wave in forced)
    return Motion(position - start, mean, (*forced, Wave(acb(fades), acb(-delta))))


def _contact(oscillator, time, wall, velocity):
    delta, square = arb(oscillator.damping), 2 * arb(oscillator.stiffness)
    drag = delta + 2 * arb(oscillator.contact_damping) * square.sqrt()
    forced = _waves(oscillator, time, lambda rate: (rate * rate + rate * delta) / (square + rate * rate + rate * drag))
    mean = 4 * arb.pi() * delta / square
    ring = acb(-drag / 2, (square - drag * drag / 4).sqrt())
    displaced = -mean - sum(wave.size.real for wave in forced)
    moving = velocity - sum((wave.size * wave.rate).real for wave in forced)
    # Re(size) is the displacement, Re(size ring) the velocity.
    size = acb(displaced, (displaced * ring.real - moving) / ring.imag)
    return Motion(wall + mean, arb(0), (*forced, Wave(size, ring)))


class _Distance(NamedTuple):
    """Distance of a motion from a wall."""

    motion: Motion
    sign: int
    place: arb

    def at(self, tau):
        return self.sign * (self.motion.position(tau) - self.place)

    def way(self, begin, end):
        """Whether the distance stays positive between two times, or ends there once; None where neither is shown."""
        piece, middle = begin.union(end), (begin + end) / 2
        rate = self.sign * self.motion.velocity(piece)
        if begin == 0 and self.at(begin).contains(0):  # the motion leaves this wall
            return _STAYS if rate > 0 else None
        if self.at(middle) + rate * (piece - middle) > 0:  # mean value theorem
            return _STAYS
        return _ENDS if rate < 0 and self.at(end) < 0 else None

    def zero(self, begin, end):
        """The time at which a distance ends that falls all the way: Newton's method with balls keeps it inside."""
        piece = begin.union(end)
        for _ in range(_NEWTON_STEPS):
            middle = piece.mid()
            piece = piece.intersection(middle - self.at(middle) / (self.sign * self.motion.velocity(piece)))
        return piece


def _first_zero(walls, motion, is_for_good=None):
    """First time after 0 at which a motion meets a wall, and which; None where it is shown that it meets none.

    `walls` are pairs of sign and place: the distance ``sign (position - place)`` is positive until then.
    """
    distances = [_Distance(motion, *wall) for wall in walls]
    begin, length = arb(0), _LONGEST_PIECE
    while begin < _LONGEST:
        end = (begin + length).mid()
        ways = [distance.way(begin, end) for distance in distances]
        if _ENDS in ways and None not in ways:
            return distances[ways.index(_ENDS)].zero(begin, end), ways.index(_ENDS)
        if None in ways:
            length = (length / 2).mid()
            assert length > _SHORTEST_PIECE, "a graze too close to decide"
            continue
        if is_for_good is not None and is_for_good(end):
            return None
        begin, length = end, min(2 * length, _LONGEST_PIECE, key=float)
    raise AssertionError("no wall is met")


def _stays(oscillator, motion):
    """A test of whether a contact above is for good: its ringing is less than the least depth without it."""
    *forced, ring = motion.waves
    slow, pieces = Motion(motion.level - arb(oscillator.half_backlash), arb(0), tuple(forced)), 256
    least = min((slow.position((arb(n) / pieces).union(arb(n + 1) / pieces)).lower() for n in range(pieces)), key=float)
    return lambda tau: bool(abs(ring.size) * (ring.rate.real * tau).exp() < least)


def departure(oscillator, t, v):
    """One application of P: time (not reduced), speed and contacts below, as balls; None in permanent contact."""
    ctx.prec = _BITS
    beta, time, velocity = arb(oscillator.half_backlash), arb(t), -arb(v)
    between = [(-1, beta), (1, -beta)]
    motion = _freeplay(oscillator, time, beta, velocity)
    tau, below = _first_zero(between, motion)
    time, velocity = time + tau, motion.velocity(tau)
    if below:
        motion = _contact(oscillator, time, -beta, velocity)
        tau, _ = _first_zero([(-1, -beta)], motion)
        time, velocity = time + tau, motion.velocity(tau)
        motion = _freeplay(oscillator, time, -beta, velocity)
        tau, _ = _first_zero([(-1, beta)], motion)
        time, velocity = time + tau, motion.velocity(tau)
    motion = _contact(oscillator, time, beta, velocity)
    exit_ = _first_zero([(1, beta)], motion, _stays(oscillator, motion))
    if exit_ is None:
        return None
    tau, _ = exit_
    return time + tau, -motion.velocity(tau), below


def _random_case(number):
    """A machine with none to three harmonics beside the first, and a departure near, below or above the graze."""
    chance = random.Random(number)
    damping = round(10.0 ** chance.uniform(-1.3, 0.0), 4)
    parts = [chance.uniform(0.1, 1.0) for _ in range(number % 4 + 1)]
    bound = chance.uniform(0.3, 0.95) * 2.0 * damping / (2.0 * 3.15 + damping) / sum(parts)
    orders = [1, *sorted(chance.sample(range(2, 8), number % 4))]
    amplitudes = [round(bound * part / order**2, 7) for part, order in zip(parts, orders, strict=True)]
    harmonics = tuple(
        (float(order), amplitude, round(chance.random(), 3))
        for order, amplitude in zip(orders[1:], amplitudes[1:], strict=True)
    )
    oscillator = Oscillator(
        damping=damping, eccentricity=amplitudes[0], half_backlash=round(damping * chance.uniform(0.2, 2.0), 4),
        stiffness=round(10.0 ** chance.uniform(1.0, 6.0), 1),
        contact_damping=chance.choice([0.0, 0.01, 0.05, 0.3, 0.7]), harmonics=harmonics,
    )  # fmt: skip
    t = chance.random()
    factor = 10.0 ** chance.uniform(-3.0, -1.0) if number % 3 == 0 else chance.uniform(0.1, 2.5)
    return oscillator, t, factor * float(grazing_velocity(oscillator, t))


def results(oscillator, t, v):
    """What the table says of a departure: all digits printed are proven."""
    landed = departure(oscillator, t, v)
    if landed is None:
        return {"outcome": "permanent contact"}
    time, speed, below = landed
    assert max(float(ball.rad()) for ball in (time, speed)) < 1e-50
    printed = {"duration": time - arb(t), "t_next": time - time.floor(), "v_next": speed}
    digits = {name: ball.str(_DIGITS, radius=False) for name, ball in printed.items()}
    return {"outcome": "returned", **digits, "lower_impacts": below}


def _entry(number):
    oscillator, t, v = _random_case(number)
    names = ("damping", "eccentricity", "half_backlash", "stiffness", "contact_damping", "harmonics")
    inputs = {name: getattr(oscillator, name) for name in names}
    return {**inputs, "t": t.hex(), "v": v.hex(), **results(oscillator, t, v)}


def main() -> None:
    """Write the table."""
    note = "see PROVENANCE.md; written by python -m tests.rattle_kernels.impact_map.balls"
    TABLE.write_text(
        json.dumps({"note": note, "entries": [_entry(number) for number in range(_ENTRIES)]}, indent=1) + "\n"
    )


if __name__ == "__main__":
    main()
