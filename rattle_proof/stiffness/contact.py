"""Contacts of the piecewise linear model in Arb balls: one linear oscillation each, and that none ends early.

With x the depth beyond a wall, w its rate, s = 1 above and -1 below, and d the damping in contact,

    x'' + d x' + omega^2 x = s a(t),    omega^2 = 2 kappa,    d = delta + 2 zeta omega.

p is its solution of the forcing's period. From (x, w) = (0, w) at time t it is after tau

    x = p(t + tau) - p(t) C + (w - p'(t)) S,    S = E sin(q tau)/q,    C = S' + d S,    E = e^(-d tau/2).
"""

from enum import Enum

from flint import acb, arb

from rattle_kernels import Oscillator
from rattle_proof.verification.flight import Slope
from rattle_proof.verification.machine import Machine, ball

_HALVINGS = 12
# Of a radian of the ringing, and how often the time between two of them is halved.
_SAMPLES, _REFINED = 8, 20


class Side(Enum):
    """The two walls."""

    UPPER = 1
    LOWER = -1


class StiffMachine:
    """An oscillator of the piecewise linear model.

    Parameters
    ----------
    oscillator : Oscillator
        Of finite stiffness, whose contacts ring (Eq. 35). Its numbers are taken as the doubles that they are.

    Attributes
    ----------
    freeplay : Machine
        What flights need of it.
    square, drag, frequency : arb
        omega^2, d and q.
    """

    def __init__(self, oscillator: Oscillator) -> None:
        damping, gap = oscillator.damping, oscillator.half_backlash
        waves = [(order, size, size, phase, phase) for order, size, phase in oscillator.all_harmonics]
        self.freeplay = Machine((damping, damping), (gap, gap), (1.0, 1.0), waves)
        self.square = 2 * arb(oscillator.stiffness)
        self.drag = arb(damping) + 2 * arb(oscillator.contact_damping) * self.square.sqrt()
        self.frequency = (self.square - self.drag * self.drag / 4).sqrt()
        self._mean = 4 * arb.pi() * arb(damping) / self.square
        self._responses = [self._response(2 * arb.pi() * wave.order) * wave.amplitude for wave in self.freeplay.waves]

    def _response(self, rate: arb) -> acb:
        """Depth of the slow part for a transmission error of amplitude 1 that turns at some rate."""
        felt = acb(-rate * rate, self.freeplay.damping * rate)
        return felt / acb(self.square - rate * rate, self.drag * rate)

    def slow_part(self, t: arb) -> tuple[arb, arb, arb]:
        """The slow part p above and its first two derivatives; those below are their negatives."""
        value, rate, bend = self._mean, arb(0), arb(0)
        for wave, response in zip(self.freeplay.waves, self._responses, strict=True):
            speed = 2 * arb.pi() * wave.order
            angle = 2 * arb.pi() * (wave.order * t + wave.phase)
            turned = response * acb(angle.cos(), angle.sin())
            value += turned.real
            rate -= speed * turned.imag
            bend -= speed * speed * turned.real
        return value, rate, bend


class Contact:
    """What contacts have in common that begin at one wall in one ball of times and speeds into it."""

    def __init__(self, machine: StiffMachine, side: Side, t: arb, w: arb) -> None:
        self.machine, self.side, self.t, self.w = machine, side, t, w
        self.slow, self.rate, self.bend = self._slow(t)
        self.felt = side.value * machine.freeplay.acceleration(t)

    def _slow(self, t: arb) -> tuple[arb, arb, arb]:
        value, rate, bend = self.machine.slow_part(t)
        sign = self.side.value
        return sign * value, sign * rate, sign * bend

    def _ringing(self, tau: arb) -> tuple[arb, arb, arb]:
        """S, its rate S', and C."""
        machine = self.machine
        left = (-machine.drag * tau / 2).exp()
        sine, cosine = (machine.frequency * tau).sin_cos()
        pulse = left * sine / machine.frequency
        change = left * cosine - machine.drag * pulse / 2
        return pulse, change, change + machine.drag * pulse

    def height(self, tau: arb) -> arb:
        """Depth x."""
        pulse, _, kept = self._ringing(tau)
        value, _, _ = self._slow(self.t + tau)
        return value - self.slow * kept + (self.w - self.rate) * pulse

    def velocity(self, tau: arb) -> arb:
        """Its rate x'."""
        pulse, change, _ = self._ringing(tau)
        _, rate, _ = self._slow(self.t + tau)
        return rate + self.slow * self.machine.square * pulse + (self.w - self.rate) * change

    def height_slopes(self, tau: arb) -> tuple[arb, arb]:
        """Derivatives of x at a given tau by the time and the speed at the beginning."""
        pulse, _, kept = self._ringing(tau)
        _, rate, _ = self._slow(self.t + tau)
        return rate - self.rate * kept - self.bend * pulse, pulse

    def arrival_slope(self, tau: arb, velocity: arb) -> Slope:
        """Derivative of (time, x') at the end, where x = 0, by the beginning."""
        machine = self.machine
        pulse, change, _ = self._ringing(tau)
        s_t = (self.w * change + self.felt * pulse) / velocity
        s_w = -pulse / velocity
        bend = self.side.value * machine.freeplay.acceleration(self.t + tau) - machine.drag * velocity
        began = self.felt - machine.drag * self.w
        return Slope(s_t, s_w, bend * s_t - change * began + machine.square * pulse * self.w, bend * s_w + change)


def lasts(contact: Contact, end: arb) -> bool:
    """Whether no contact of a ball ends before the end that is known of it.

    Parameters
    ----------
    contact : Contact
        Of all beginnings, with speeds above 0.
    end : arb
        Holds a root of x for each.

    Returns
    -------
    bool
        The time up to the last end is cut into pieces. In each but the last x' > 0 or x > 0: so x > 0 at its end, as
        it begins at x >= 0. In the last x' < 0: x falls to its root there.
    """
    last = end.upper()
    waiting = [(arb(0), last, 0)]
    while waiting:
        begin, stop, depth = waiting.pop()
        piece = ball(begin, stop)
        rate = contact.velocity(piece)
        if rate > 0 or contact.height(piece) > 0 or (stop == last and rate < 0):
            continue
        if depth == _HALVINGS:
            return False
        middle = piece.mid()
        waiting += [(middle, stop, depth + 1), (begin, middle, depth + 1)]
    return True


def first_end(contact: Contact) -> float | None:
    """About when a contact ends, if it does within a period. Nothing rests on it."""
    step = float(1 / (_SAMPLES * contact.machine.frequency))
    tau = step
    while contact.height(arb(tau)) > 0:
        tau += step
        if tau > 1.0:
            return None
    low = tau - step
    for _ in range(_REFINED):
        middle = 0.5 * (low + tau)
        low, tau = (middle, tau) if contact.height(arb(middle)) > 0 else (low, middle)
    return tau
