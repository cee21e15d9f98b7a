"""The acceleration at rest is positive (Eq. 8), and the quiet core: its departures lose their action at every bounce.

The core is swept in departure time and duration, strip by strip from no duration at all upwards. At one departure time
a faster flight takes longer: where a strip lies above the core, so do all longer ones.
"""

from collections.abc import Iterator

from flint import arb

from rattle_proof.verification.claims import Core
from rattle_proof.verification.flight import Flight
from rattle_proof.verification.impact import image
from rattle_proof.verification.machine import Machine, ball, within
from rattle_proof.verification.targets.low_bounces import low_bounces
from rattle_proof.verification.verdict import Failure, Part, contradicted, undecided

COLUMNS = 64
"""Parts of a period in which the core is proven."""
_PHASES = 1024
_SHORTEST, _STRIP = 1 / 64, 1.15
_MOST_STRIPS = 60
# How often tolerances may be cut in two.
_CUTS = 6
_DEPTH, _DEPTH_OF_EDGE = 28, 8
# A departure that refutes the core is sought by ever faster ones.
_TRIALS, _FASTER = 40, 1.01


def acceleration_at_rest(machine: Machine) -> Part:
    """Prove that a(t) > 0, and give the machine its least value."""
    part, least = Part("a(t) > 0 (Eq. 8)", _PHASES), arb.pos_inf()
    for i in range(_PHASES):
        felt = machine.acceleration(ball(i, i + 1) / _PHASES)
        least = least.min(felt.lower())
        place = f"t in [{i}, {i + 1}]/{_PHASES}"
        if felt > 0:
            part.add(1)
        elif machine.acceleration(arb(i) / _PHASES) <= 0:
            part.add(1, [contradicted(place, "a(t) is not positive there")])
        else:
            part.add(1, [undecided(place)])
    machine.least_acceleration = float(least) * (1 - 1e-15)
    return part


def try_column(machine: Machine, core: Core, column: int) -> Failure | None:
    """Prove that every departure of the core falls quiet, of one of `COLUMNS` parts of a period."""
    return _try_times(machine, core, ball(column, column + 1) / COLUMNS, _CUTS)


def _try_times(machine: Machine, core: Core, t: arb, cuts: int) -> Failure | None:
    """Which strip fails; tolerances are cut where one does, for an uncertain a blurs the action."""
    failure = next((each for each in _column(machine, core, t) if each is not None), None)
    halves = machine.halves() if failure is not None and not failure.contradicted and cuts else []
    if not halves:
        return failure
    tried = (_try_times(half, core, t, cuts - 1) for half in halves)
    return next((each for each in tried if each is not None), None)


def parts_of(machine: Machine, count: int) -> list[Machine]:
    """Machines that together are one: so many, or one that has no tolerances."""
    machines = [machine]
    while len(machines) < count:
        halved = [half for each in machines for half in each.halves()]
        if not halved:
            break
        machines = halved
    return machines


def _column(machine: Machine, core: Core, t: arb) -> Iterator[Failure | None]:
    begin, end = arb(0), arb(_SHORTEST / machine.highest_order)
    for _ in range(_MOST_STRIPS):
        yield from _strip(machine, core, t, ball(begin, end), _DEPTH)
        if _above(machine, core, t, end, _DEPTH_OF_EDGE):
            return
        begin, end = end, end * _STRIP
    yield undecided(f"departures at t = {_shown(t)}", f"flights as long as {_shown(end)} may belong to the core")


def _above(machine: Machine, core: Core, t: arb, tau: arb, depth: int) -> bool:
    """Whether all flights of a duration lie above the core."""
    if _speed(machine, t, tau) ** 3 >= core.level * machine.acceleration(t):
        return True
    return depth > 0 and all(_above(machine, core, half, tau, depth - 1) for half in halves(t))


def _speed(machine: Machine, t: arb, tau: arb) -> arb:
    """Speeds of departures that return after a time of `tau` > 0, in the mean value form.

    From y(tau) = 0 the speed is ``(4 pi tau + e(s) - e(t))/E - 4 pi - e'(t)``. It grows by y'/E with tau, where y' is
    the speed of arrival, and by ``(e'(s) - e'(t) - e''(t) E)/E`` with t.
    """
    middle = Flight(machine, t.mid(), arb(0))
    reached, _ = machine.decay(tau.mid())
    centre = middle.height(tau.mid()) / reached
    wide = Flight(machine, t, -centre)
    by_t, reached = wide.height_slopes(tau)
    rough = Flight(machine, t, arb(0)).height(tau) / reached
    arrived = Flight(machine, t, -rough).velocity(tau)
    sharp = centre + by_t / reached * (t - t.mid()) + arrived / reached * (tau - tau.mid())
    return within(sharp, rough)


def _strip(machine: Machine, core: Core, t: arb, tau: arb, depth: int) -> Iterator[Failure | None]:
    bounces = low_bounces(machine, t, tau)
    speed = within(_speed(machine, t, tau), bounces.speed) if tau > 0 else bounces.speed
    if speed**3 >= core.level * machine.acceleration(t):
        return
    clear = speed**2 < 2 * machine.least_acceleration * machine.gap
    if (clear and bounces.falls) or (tau > _SHORTEST and _falls(machine, t, speed)):
        yield None
    elif depth == 0:
        yield _why(machine, core, t, tau)
    elif depth % 2:
        for half in halves(t):
            yield from _strip(machine, core, half, tau, depth - 1)
    else:
        for half in halves(tau):
            yield from _strip(machine, core, t, half, depth - 1)


def halves(a: arb) -> tuple[arb, arb]:
    """The lower and the upper half of a ball."""
    return a.lower().union(a.mid()), a.mid().union(a.upper())


def _falls(machine: Machine, t: arb, v: arb) -> bool:
    """Whether the action falls at all departures of a box, of which some may meet -beta."""
    mapped = image(machine, t.mid(), v.mid(), t, v)
    if mapped is None:
        return False
    return bool(_action(machine, mapped.all_t, mapped.all_v) < _action(machine, t, v))


def _action(machine: Machine, t: arb, v: arb) -> arb:
    return v**3 / machine.acceleration(t)


def _why(machine: Machine, core: Core, t: arb, tau: arb) -> Failure:
    """Refute it by a departure near by, if that can be done."""
    start, v = t.mid(), low_bounces(machine, t.mid(), tau.mid()).speed.mid()
    place = f"t = {_shown(start)}, v = {_shown(v)}"
    for _ in range(_TRIALS):
        before, mapped = _action(machine, start, v), image(machine, start, v, start, v)
        if not before < core.level:
            break
        after = None if mapped is None else _action(machine, mapped.all_t, mapped.all_v)
        if after is not None and after >= before:
            place = f"t = {_shown(start)}, v = {_shown(v)}"
            return contradicted(place, f"the action v^3/a grows from {_shown(before)} to {_shown(after)}")
        v = (v * _FASTER).mid()
    return undecided(place)


def _shown(a: arb) -> str:
    return f"{float(a.mid()):.9g}"
