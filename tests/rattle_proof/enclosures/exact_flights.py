"""P of the impacting model at one departure, in balls of 256 bits (Arb, by python-flint).

A flight is written in its plainest form, of which the kernels' share nothing: what cancels is paid for in digits. Roots
are sought by Newton's method and then proven: the function has different signs on the two sides of a tiny ball. Turning
points decide which wall is met, and they are minima, since the acceleration at rest is positive (Eq. 8).
"""

from typing import NamedTuple

from flint import arb, ctx

from rattle_kernels.impact_map.flights import LOWER, UPPER, fly_over, next_contact

BITS = 256
_HALVINGS, _NEWTON_STEPS = 12, 60
_SETTLED = arb(2) ** -200
_BALLS = [arb(2) ** -bits for bits in range(190, 80, -15)]


class Point(NamedTuple):
    """Departure from +beta after an impact: time and speed, both balls."""

    t: arb
    v: arb


class Flight:
    """A flight after its departure, by the time since."""

    def __init__(self, exact, t, w):
        self.exact, self.t, self.w = exact, arb(t), arb(w)
        self.start, rate, _ = exact.error(self.t)
        self.drag = self.w - 4 * arb.pi() - rate

    def displacement(self, tau):
        value, _, _ = self.exact.error(self.t + tau)
        fallen = (-self.exact.damping * tau).exp()
        return 4 * arb.pi() * tau + value - self.start + self.drag * (1 - fallen) / self.exact.damping

    def velocity(self, tau):
        _, rate, _ = self.exact.error(self.t + tau)
        return 4 * arb.pi() + rate + self.drag * (-self.exact.damping * tau).exp()

    def acceleration(self, tau):
        return self.exact.acceleration(self.t + tau) - self.exact.damping * self.velocity(tau)


class ExactMap:
    """P of one oscillator, its parameters taken as the doubles that they are."""

    def __init__(self, oscillator):
        ctx.prec = BITS
        self.oscillator = oscillator
        self.damping, self.half_backlash = arb(oscillator.damping), arb(oscillator.half_backlash)
        self.restitution = arb(oscillator.restitution)
        waves = ((1.0, oscillator.eccentricity, 0.0), *oscillator.harmonics)
        self.waves = [(arb(order), arb(amplitude), arb(phase)) for order, amplitude, phase in waves]

    def error(self, t):
        """Transmission error and its first two derivatives."""
        value, rate, bend = arb(0), arb(0), arb(0)
        for order, amplitude, phase in self.waves:
            sine, cosine = (2 * (order * t + phase)).sin_cos_pi()
            speed = 2 * arb.pi() * order
            value += amplitude * cosine
            rate -= amplitude * speed * sine
            bend -= amplitude * speed**2 * cosine
        return value, rate, bend

    def acceleration(self, t):
        """What an object at rest in freeplay feels."""
        _, rate, bend = self.error(t)
        return self.damping * (4 * arb.pi() + rate) + bend

    def turning_point(self, flight, latest):
        """Duration and height of the turning point of a flight from +beta that has turned by `latest`."""
        early, late = arb(0), arb(latest)
        for _ in range(_HALVINGS):
            cut = (early + late) / 2
            early, late = (cut, late) if flight.velocity(cut) < 0 else (early, cut)
        tau = _root(flight.velocity, flight.acceleration, (early + late) / 2)
        return tau, flight.displacement(tau)

    def arrival(self, flight, height, near):
        """Duration and velocity of an arrival, given a guess."""
        tau = _root(lambda at: flight.displacement(at) - height, flight.velocity, arb(near))
        return tau, flight.velocity(tau)

    def lower_impact(self, t, v):
        """Departure from -beta after an impact there of a flight from +beta; None if that keeps clear of -beta."""
        flight = Flight(self, arb(t), -arb(v))
        turn, lowest = self.turning_point(flight, self.over(t, v))
        if lowest + 2 * self.half_backlash > 0:
            return None
        contact = next_contact(self.oscillator, UPPER, float(t), -float(v), 1.0)
        # Near grazing the kernel may take the other wall: a parabola about the turning point is good enough there.
        parabola = float(turn - (-2 * (lowest + 2 * self.half_backlash) / flight.acceleration(turn)).sqrt())
        down, velocity = self.arrival(
            flight, -2 * self.half_backlash, contact.duration if contact.wall == LOWER else parabola
        )
        assert down < turn
        return Point(arb(t) + down, -self.restitution * velocity)

    def over(self, t, v):
        """Duration, about, of a flight from +beta as if -beta were not there."""
        return fly_over(self.oscillator, float(t), -float(v)).duration

    def image(self, t, v):
        """Image of a departure under P: time, which is not reduced, and speed."""
        lower = self.lower_impact(t, v)
        if lower is None:
            tau, velocity = self.arrival(Flight(self, arb(t), -arb(v)), arb(0), self.over(t, v))
            return Point(arb(t) + tau, self.restitution * velocity)
        near = next_contact(self.oscillator, LOWER, float(lower.t), float(lower.v), 1.0).duration
        up, velocity = self.arrival(Flight(self, *lower), 2 * self.half_backlash, near)
        assert velocity > 0
        return Point(lower.t + up, self.restitution * velocity)


def _root(function, slope, guess):
    tau = guess.mid()
    for _ in range(_NEWTON_STEPS):
        step = (function(tau) / slope(tau)).mid()
        tau = (tau - step).mid()
        if abs(step) < _SETTLED:
            break
    # What a second flight begins with is a ball itself.
    for ball in _BALLS:
        before, after = function(tau - ball), function(tau + ball)
        if (before > 0 and after < 0) or (before < 0 and after > 0):
            return (tau - ball).union(tau + ball)
    raise ArithmeticError("no sign on either side of a root")
