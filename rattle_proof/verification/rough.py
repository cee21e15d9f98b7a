"""One flight in plain numbers: where enclosures are looked for. Nothing rests on it."""

from collections.abc import Callable

from flint import arb
from scipy.optimize import brentq

from rattle_proof.verification.flight import Flight
from rattle_proof.verification.machine import Machine

_DOUBLINGS = 60


class Rough:
    """The flight of the middle of two balls."""

    def __init__(self, machine: Machine, t: arb, w: arb) -> None:
        self.flight = Flight(machine, t.mid(), w.mid())
        self.scale = abs(float(w.mid())) / max(float(self.flight.felt.mid()), 1e-300)

    def height(self, tau: float) -> float:
        """Displacement y."""
        return float(self.flight.height(arb(tau)).mid())

    def velocity(self, tau: float) -> float:
        """Velocity y'."""
        return float(self.flight.velocity(arb(tau)).mid())

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
