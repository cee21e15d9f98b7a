"""The machine of a certificate in Arb balls: the forcing that an object in freeplay feels."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from flint import arb

from rattle_kernels import Oscillator

Ranges = tuple[tuple[float, float], ...]

UNIT = arb(0, 1)
"""The ball from -1 to 1."""


def ball(low: float | arb, high: float | arb) -> arb:
    """The ball of all numbers between two."""
    return arb(low).union(arb(high))


def within(a: arb, b: arb) -> arb:
    """What two balls that hold the same number have in common."""
    return a.intersection(b) if a.overlaps(b) else a


class Wave(NamedTuple):
    """One harmonic ``amplitude cos(2 pi (order t + phase))`` of the transmission error."""

    order: arb
    amplitude: arb
    phase: arb


class Machine:
    """All oscillators with parameters in given balls.

    Freeplay is ``Phi'' + delta Phi' = a(t)`` with ``a = 4 pi delta + e'' + delta e'``, where e is the transmission
    error: so that ``4 pi t + e(t)`` solves it.

    Parameters
    ----------
    damping, half_backlash, restitution : (float, float)
        Least and greatest value.
    harmonics : sequence of (order, amplitude, amplitude, phase, phase)
        Least and greatest values likewise; the first is the eccentricity.

    Attributes
    ----------
    least_acceleration : float
        A bound below a(t), as `acceleration_at_rest` proves it; 0 until then.
    """

    def __init__(
        self,
        damping: Sequence[float],
        half_backlash: Sequence[float],
        restitution: Sequence[float],
        harmonics: Sequence[Sequence[float]],
    ) -> None:
        self._told = [tuple(map(float, each)) for each in (damping, half_backlash, restitution, *harmonics)]
        self.damping = ball(*damping)
        self.least_damping, self.most_damping = arb(damping[0]), arb(damping[1])
        self.gap = 2 * ball(*half_backlash)
        self.restitution = ball(*restitution)
        self.least_acceleration = 0.0
        self.waves = [Wave(arb(row[0]), ball(row[1], row[2]), ball(row[3], row[4])) for row in harmonics]

    @classmethod
    def of(cls, told: dict[str, Any]) -> "Machine":
        """The machine that a certificate tells."""
        return cls(told["damping"], told["half_backlash"], told["restitution"], told["harmonics"])

    def halves(self) -> "list[Machine]":
        """Two machines that together are this one, by half of the tolerance that matters most; none without any."""
        widest, place = max((size, place) for place, size in self._sizes().items())
        if widest == 0.0:
            return []
        row, first = place
        low, high = self._told[row][first : first + 2]
        found = []
        for ends in ((low, 0.5 * (low + high)), (0.5 * (low + high), high)):
            told = list(self._told)
            told[row] = (*told[row][:first], *ends, *told[row][first + 2 :])
            half = Machine(told[0], told[1], told[2], told[3:])
            half.least_acceleration = self.least_acceleration
            found.append(half)
        return found

    def _sizes(self) -> dict[tuple[int, int], float]:
        """Each tolerance as a part of what it changes, by its row and the place of its lower end."""
        sizes = {(row, 0): (self._told[row][1] - self._told[row][0]) / self._told[row][1] for row in range(3)}
        drag = 4.0 * np.pi * self._told[0][1]
        for row, (order, low, high, early, late) in enumerate(self._told[3:], 3):
            bend = (2.0 * np.pi * order) ** 2 / drag
            sizes[row, 1], sizes[row, 3] = bend * (high - low), bend * high * 2.0 * np.pi * (late - early)
        return sizes

    @property
    def ranges(self) -> tuple[tuple[float, float], ...]:
        """Least and greatest value of each parameter."""
        rows = [(each[1:3], each[3:5]) for each in self._told[3:]]
        return tuple((each[0], each[1]) for each in (*self._told[:3], *(pair for row in rows for pair in row)))

    @property
    def highest_order(self) -> float:
        """Of the harmonics."""
        return max(float(wave.order) for wave in self.waves)

    def error(self, t: arb) -> tuple[arb, arb, arb]:
        """Transmission error and its first two derivatives by time."""
        value = rate = bend = arb(0)
        for wave in self.waves:
            sine, cosine = _sine_cosine(wave.order * t + wave.phase)
            speed = 2 * arb.pi() * wave.order
            first = wave.amplitude * speed
            value += wave.amplitude * cosine
            rate -= first * sine
            bend -= first * speed * cosine
        return value, rate, bend

    def acceleration(self, t: arb) -> arb:
        """a(t): what an object at rest feels."""
        _, rate, bend = self.error(t)
        return self.damping * (4 * arb.pi() + rate) + bend

    def derivatives(self, t: arb, count: int) -> list[arb]:
        """a(t) and its derivatives, `count` in all."""
        found = [4 * arb.pi() * self.damping] + [arb(0)] * (count - 1)
        for wave in self.waves:
            sine, cosine = _sine_cosine(wave.order * t + wave.phase)
            speed = 2 * arb.pi() * wave.order
            size = wave.amplitude * speed
            for k in range(count):
                found[k] -= size * (speed * cosine + self.damping * sine)
                sine, cosine, size = cosine, -sine, size * speed
        return found

    def decay(self, tau: arb) -> tuple[arb, arb]:
        """``E = (1 - e^(-delta tau))/delta`` and ``D = e^(-delta tau)``; no duration is negative."""
        low, high = tau.lower().nonnegative_part(), tau.upper().nonnegative_part()
        # E grows with tau and falls with delta.
        least = -(-self.most_damping * low).expm1() / self.most_damping
        most = -(-self.least_damping * high).expm1() / self.least_damping
        return least.union(most), (-self.damping * low.union(high)).exp()


def holds(machine: Machine, oscillator: Oscillator) -> bool:
    """Whether an oscillator is one of a machine's."""
    waves = [(1.0, oscillator.eccentricity, 0.0), *oscillator.harmonics]
    pairs = [
        (machine.damping, oscillator.damping),
        (machine.gap, 2 * oscillator.half_backlash),
        (machine.restitution, oscillator.restitution),
    ]
    for wave, told in zip(machine.waves, waves, strict=False):
        pairs += zip(wave, told, strict=True)
    same = len(machine.waves) == len(waves) and not np.isfinite(oscillator.stiffness)
    return same and all(each.contains(arb(value)) for each, value in pairs)


def cover(parts: Sequence[Machine], machine: Machine) -> bool:
    """Whether each oscillator of a machine is one of some part's, all of the same orders."""
    orders = [float(wave.order) for wave in machine.waves]
    if any([float(wave.order) for wave in part.waves] != orders for part in parts):
        return False
    return _covered(machine.ranges, [part.ranges for part in parts])


def _covered(whole: Ranges, parts: Sequence[Ranges]) -> bool:
    """Whether all of a box of parameters lies in some boxes: it is cut where one of them ends inside."""
    for part in parts:
        meets = all(low <= b and a <= high for (low, high), (a, b) in zip(whole, part, strict=True))
        inside = [n for n, (low, high) in enumerate(whole) for end in part[n] if low < end < high]
        if meets and not inside and all(a <= low <= high <= b for (low, high), (a, b) in zip(whole, part, strict=True)):
            return True
        if meets and inside:
            n = inside[0]
            cut = next(end for end in part[n] if whole[n][0] < end < whole[n][1])
            sides = ((whole[n][0], cut), (cut, whole[n][1]))
            return all(_covered((*whole[:n], side, *whole[n + 1 :]), parts) for side in sides)
    return False


def _sine_cosine(turns: arb) -> tuple[arb, arb]:
    """Sine and cosine of an angle in turns; sharper at the extremes than a bound by the largest slope."""
    middle = turns.mid()
    sine, cosine = (2 * middle).sin_cos_pi()
    if turns.is_exact():
        return sine, cosine
    off = 2 * arb.pi() * (turns - middle)
    bent = arb(0, (off * off).abs_upper() / 2)
    return (
        within(sine + cosine * off + bent, UNIT),
        within(cosine - sine * off + bent, UNIT),
    )
