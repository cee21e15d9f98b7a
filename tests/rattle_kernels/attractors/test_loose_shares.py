"""What loose gears end in, by brute force: flights that are sampled, walls found by halving, rests by low speed."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from rattle_kernels import Oscillator, shares_of

_CONTACTS = 800
_HALVINGS = 55
# Two departures are one within this part of a period and of the scale of speeds.
_SAME = 1e-6


class _Gear:
    """A loose gear with its forcing in closed form: y'' + delta y' = a(t) = 4 pi delta + e'' + delta e'."""

    def __init__(self, oscillator):
        self.damping, self.beta, self.restitution = oscillator.damping, oscillator.half_backlash, oscillator.restitution
        orders, amplitudes, phases = zip((1, oscillator.eccentricity, 0.0), *oscillator.harmonics, strict=True)
        self.rates = 2.0 * math.pi * np.array(orders)
        self.amplitudes, self.turns = np.array(amplitudes), 2.0 * math.pi * np.array(phases)
        ticks = np.arange(4097) / 4096
        changes = np.flatnonzero(np.diff(np.sign(self.felt(ticks))))
        self.ends_of_arcs = _halved(self.felt, ticks[changes], ticks[changes + 1])

    def error(self, t, derivative=0):
        """e or one of its derivatives: each turns a cosine by a quarter."""
        angle = self.rates * np.asarray(t)[..., None] + (self.turns + 0.5 * math.pi * derivative)
        return np.cos(angle) @ (self.amplitudes * self.rates**derivative)

    def felt(self, t):
        """a(t)."""
        return self.damping * (4.0 * math.pi + self.error(t, 1)) + self.error(t, 2)

    def fly(self, t, y, w, tau):
        """Displacement some time after the beginning of flights."""
        own = np.expm1(-self.damping * tau) / self.damping * (4.0 * math.pi + self.error(t, 1) - w)
        return y + 4.0 * math.pi * tau + self.error(t + tau) - self.error(t) + own

    def arrive(self, t, w, tau):
        """Velocity then."""
        return (
            4.0 * math.pi
            + self.error(t + tau, 1)
            - np.exp(-self.damping * tau) * (4.0 * math.pi + self.error(t, 1) - w)
        )

    def arc(self, t):
        """Number of the arc at a time."""
        return np.floor(t) * self.ends_of_arcs.size + np.searchsorted(self.ends_of_arcs, t % 1.0)

    def left_of_arc(self, t):
        later = self.ends_of_arcs[None] - (t % 1.0)[:, None]
        return np.where(later > 0.0, later, later + 1.0).min(axis=1)


def _halved(function, low, high):
    """Where functions change their sign between two places."""
    above = function(high) > 0.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        beyond = (function(middle) > 0.0) == above
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    return high


class _Contacts(NamedTuple):
    """Contacts of many motions, shape (contacts, motions): arrival, departure, wall, speed of leaving, rest."""

    arrives: np.ndarray
    leaves: np.ndarray
    wall: np.ndarray
    speed: np.ndarray
    rests: np.ndarray


def _next_contact(gear, t, wall, w, ticks):
    """Duration of flights from a wall, and the wall that they meet: the first sample beyond one brackets it."""
    y, duration, meets = wall * gear.beta, np.full(t.size, np.nan), np.zeros(t.size)
    begun, going = 0.0, np.arange(t.size)
    while going.size:
        here = gear.fly(t[going, None], y[going, None], w[going, None], begun + ticks)
        beyond = np.abs(here) > gear.beta
        first, met = beyond.argmax(axis=1), beyond.any(axis=1)
        rows, first = going[met], first[met]
        side = np.sign(here[met, first])

        def depth(tau, rows=rows, side=side):
            return side * gear.fly(t[rows], y[rows], w[rows], tau) - gear.beta

        duration[rows] = _halved(depth, begun + ticks[first] - ticks[0], begun + ticks[first])
        meets[rows] = side
        begun, going = begun + 1.0, going[~met]
    return duration, meets


def _follow(gear, t, v, samples, slow):
    """Contacts of motions. A gear that leaves a wall more slowly than `slow` rests, if bounces end within the arc."""
    ticks = np.arange(1, samples + 1) / samples
    wall, w, kept = np.ones(t.size), -v, []
    for _ in range(_CONTACTS):
        duration, wall_met = _next_contact(gear, t, wall, w, ticks)
        arrives, wall, speed = t + duration, wall_met, gear.restitution * np.abs(gear.arrive(t, w, duration))
        pressed, left = wall * gear.felt(arrives), gear.left_of_arc(arrives)
        # Bounces of a constant force last 2 v/p, each r times as long as the one before.
        rests = (speed < slow) & (pressed > 0.0) & (4.0 * speed < pressed * (1.0 - gear.restitution) * left)
        t, speed = np.where(rests, arrives + left, arrives), np.where(rests, 0.0, speed)
        w = -wall * speed
        kept.append((arrives, t, wall, speed, rests))
    return _Contacts(*map(np.array, zip(*kept, strict=True)))


def _name(gear, contacts, scale):
    """P(m, n+, n-) that the last contacts of one motion repeat, with a star for a rest; a chatter is one contact.

    Empty where they repeat nothing three times.
    """
    arcs, last = gear.arc(contacts.arrives), len(contacts.wall) - 1
    kept, chatter = [], (0.0, -1.0)
    for i in range(last, -1, -1):
        place = contacts.wall[i], arcs[i]
        if contacts.rests[i]:
            chatter = place
        elif place == chatter:
            continue
        kept.append(i)
    # The last chatter may not have come to its end.
    kept = [i for i in kept if (contacts.wall[i], arcs[i]) != (contacts.wall[last], arcs[last])]
    upper = [i for i in kept if contacts.wall[i] > 0.0]
    for earlier in upper[1 : len(upper) // 3]:
        around = contacts.leaves[upper[0]] - contacts.leaves[earlier]
        if max(abs(around - round(around)), abs(contacts.speed[upper[0]] - contacts.speed[earlier]) / scale) < _SAME:
            turn = kept[kept.index(upper[0]) : kept.index(earlier)]
            walls = contacts.wall[turn]
            star = "*" if contacts.rests[turn].any() else ""
            return f"P({round(around)},{int((walls > 0).sum())},{int((walls < 0).sum())}){star}"
    return ""


def _names(gear, t, v, samples, slow, scale):
    contacts = _follow(gear, t, v, samples, slow)
    return np.array([_name(gear, _Contacts(*(each[:, i] for each in contacts)), scale) for i in range(t.size)])


def _machine(gamma, r, half_backlash, second=()):
    damping = 0.6
    first = gamma * damping / math.pi / (1.0 + sum(2.0 * share for share, _ in second))
    return Oscillator(
        damping, first, half_backlash, restitution=r,
        harmonics=tuple((2, share * first / 2.0, phase) for share, phase in second),
    )  # fmt: skip


# With one harmonic, and with a second one of the given share and phase. None has chaos, not even a transient, on which
# two wrong answers agree by chance.
_MACHINES = [
    _machine(1.1, 0.6, 0.6),
    _machine(1.3, 0.6, 0.6),
    _machine(3.0, 0.8, 0.2),
    _machine(4.0, 1.0, 1.5),
    _machine(1.7, 0.7, 0.6, [(0.4, 0.6)]),
    _machine(2.0, 0.6, 0.6, [(0.5, 0.4)]),
]


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("machine", _MACHINES)
def test_shares_are_those_of_brute_force(machine):
    """The same departures on both sides, so that no share has a statistical error.

    What brute force finds depends on its samples, which may pass over a low bounce or a graze, and on the speed at
    which it lets a gear rest. Departures whose end changes with both are not resolved by it, nor are those that have
    not settled. The others must end in the same motions, so shares differ by the share of unresolved ones at most.
    """
    rng = np.random.default_rng(1)
    gear, scale = _Gear(machine), math.sqrt(16.0 * math.pi * machine.damping * machine.half_backlash)
    t, v = rng.random(200), scale * rng.uniform(0.01, 2.0, 200)
    coarse, fine = (_names(gear, t, v, samples, slow * scale, scale) for samples, slow in ((64, 1e-4), (144, 1e-6)))
    resolved = (coarse == fine) & (fine != "")
    unresolved = 1.0 - resolved.mean()
    assert unresolved < 0.05
    found = shares_of(machine, t, v)
    motions = np.array([each.name for each in found.attractors])
    assert motions[found.solution][resolved].tolist() == fine[resolved].tolist()
    for name in {*motions.tolist(), *fine[resolved].tolist()}:
        assert abs((fine[resolved] == name).sum() / t.size - found.share[motions == name].sum()) <= unresolved + 1e-12
