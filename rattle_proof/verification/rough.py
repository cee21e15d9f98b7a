"""One flight in plain numbers: where enclosures are looked for. Nothing rests on it."""

from collections.abc import Callable
from math import cos, expm1, pi, sin

from flint import arb
from scipy.optimize import brentq

from rattle_proof.verification.machine import Machine

_DOUBLINGS = 60


class Rough:
    """The flight of the middle of two balls.

    Terms that nearly cancel where a flight is short are written as products.
    """

    def __init__(self, machine: Machine, t: arb, w: arb) -> None:
        self.damping, self.w, time = (float(each.mid()) for each in (machine.damping, w, t))
        waves = [tuple(float(each.mid()) for each in wave) for wave in machine.waves]
        # Half the speed of each wave's angle, its amplitude, and the angle at departure.
        self.waves = [(pi * order, size, 2 * pi * (order * time + phase)) for order, size, phase in waves]
        self.rate = -sum(2 * half * size * sin(angle) for half, size, angle in self.waves)
        bend = -sum(4 * half * half * size * cos(angle) for half, size, angle in self.waves)
        self.scale = abs(self.w) / max(self.damping * (4 * pi + self.rate) + bend, 1e-300)

    def height(self, tau: float) -> float:
        """Displacement y."""
        reached = -expm1(-self.damping * tau) / self.damping
        risen = sum(size * sin(angle + half * tau) * sin(half * tau) for half, size, angle in self.waves)
        return (self.w - self.rate) * reached + 4 * pi * (tau - reached) - 2 * risen

    def velocity(self, tau: float) -> float:
        """Velocity y'."""
        lost = -expm1(-self.damping * tau)
        risen = sum(half * size * cos(angle + half * tau) * sin(half * tau) for half, size, angle in self.waves)
        return self.w + (4 * pi + self.rate - self.w) * lost - 4 * risen

    def turn(self) -> float:
        """When it turns, if it starts downwards."""
        return _root(self.velocity, 0.0, _beyond(self.velocity, 0.0, self.scale))

    def reach(self, height: float, early: float, step: float) -> float:
        """When it rises to a height, from some time on."""

        def missed(tau: float) -> float:
            return self.height(tau) - height

        return _root(missed, early, _beyond(missed, early, step))

    def fall(self, height: float, turn: float) -> float:
        """When it falls to a height, on its way to the turning point."""
        return _root(lambda tau: height - self.height(tau), 0.0, turn)


def _beyond(function: Callable[[float], float], early: float, step: float) -> float:
    for _ in range(_DOUBLINGS):
        if function(early + step) > 0:
            break
        step *= 2
    return early + step


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    if not function(low) < 0 < function(high):  # fewer digits than that would take
        return high
    return float(brentq(function, low, high, xtol=1e-300, rtol=1e-14))
