"""Motions of finite stiffness that attract: by proof."""

import importlib.util
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle_kernels import (
    Attractor,
    AttractorKind,
    Oscillator,
    Outcome,
    check_domain,
    find_attractors,
    largest_grazing_speed,
    next_impacts,
)
from worker.errors import InvalidJob
from worker.gear_pair import GearPair

if TYPE_CHECKING:
    from rattle_proof.stiffness.contact import StiffMachine

# Applications of P before motions are looked for, as many departures at most from which they are, and binary digits.
_SETTLED, _SEARCHED, _BITS = 2000, 64, 128
_LONGEST = 16


@dataclass(frozen=True)
class ProvenContact:
    """Whether permanent contact is proven to exist and to attract, and what around it stays in contact.

    Attributes
    ----------
    proven : bool
    why : str
        Why it is not; empty if it is.
    depth : float
        A bound below the depth beyond +beta of the motion without ringing. A motion in contact that rings by less never
        leaves it: ``|(z, (z' + d z/2)/q)| < depth``, z its difference from that motion. 0 if it is not proven.
    velocity : float
        Of those, the ones that differ by velocity alone do so by less than this; 0 likewise.
    decay : float
        So they come to it, like ``e^(-decay t)``; 0 likewise.
    """

    proven: bool
    why: str = ""
    depth: float = 0.0
    velocity: float = 0.0
    decay: float = 0.0


@dataclass(frozen=True)
class ProvenOrbit:
    """Whether a motion is proven to be an attracting periodic orbit, and what comes to it.

    Attributes
    ----------
    name : str
        ``P(m, n+, n-)``, or chaotic or undecided, of which nothing is proven. What a proof says of an orbit is that it
        has n+ contacts with +beta in a turn, n- with -beta, and takes m periods.
    proven : bool
    why : str
        Why it is not; empty if it is.
    time, velocity : float
        The middle c of a disc ``|F (x - c)| <= radius`` of departures x = (time, speed). Like all numbers that follow
        they are NaN if it is not proven.
    frame : tuple of tuple of float
        F, row by row; empty if it is not proven.
    radius : float
        All departures of the disc come to the orbit, of which it holds just one departure.
    error : float
        That one differs from c by at most so much, by F.
    contraction : float
        A turn brings all departures of the disc closer to each other, by F, by this factor or a smaller one.
    slowest : float
        A bound below the speeds at which any motion from the disc crosses a wall in a turn.
    """

    name: str
    proven: bool
    why: str = ""
    time: float = np.nan
    velocity: float = np.nan
    frame: tuple[tuple[float, float], ...] = ()
    radius: float = np.nan
    error: float = np.nan
    contraction: float = np.nan
    slowest: float = np.nan


@dataclass(frozen=True)
class ProvenOrbits:
    """What is proven of the motions of a machine of finite stiffness.

    Attributes
    ----------
    oscillator : dict
        The machine in the model.
    contact : ProvenContact
    orbits : tuple of ProvenOrbit
        All other motions that were found. That no other exists is not proven.
    """

    oscillator: dict[str, Any]
    contact: ProvenContact
    orbits: tuple[ProvenOrbit, ...]

    def to_dict(self) -> dict[str, Any]:
        """All of it, for JSON: numbers that are not there are None.

        Returns
        -------
        dict
        """
        told = asdict(self)
        for orbit in told["orbits"]:
            if not orbit["proven"]:
                orbit.update({name: None for name, value in orbit.items() if isinstance(value, float)})
        return told

    def __str__(self) -> str:
        """In sentences."""
        contact = self.contact
        told = f"attracts what rings by less than {_down(contact.depth)}" if contact.proven else _not(contact.why)
        lines = [f"permanent contact: {told}"]
        for orbit in self.orbits:
            told = _not(orbit.why)
            if orbit.proven:
                told = (
                    f"attracts a disc of radius {_down(orbit.radius)} around t = {orbit.time:.6f}, "
                    f"v = {orbit.velocity:.6f}; no wall is crossed below {_down(orbit.slowest)}"
                )
            lines.append(f"{orbit.name}: {told}")
        return "\n".join(lines)


def prove_orbits(machine: GearPair | Oscillator | str | Path, *, departures: int = 400, seed: int = 0) -> ProvenOrbits:
    """Prove that motions of a machine of finite stiffness attract: permanent contact and periodic orbits.

    Motions are sought by numbers, from random departures. Around each periodic orbit that is found, a disc of
    departures is proven to be mapped into itself and contracted: so it holds just one periodic orbit, to which all of
    them come. Flights and contacts are enclosed by Arb balls in closed form.

    Parameters
    ----------
    machine : Oscillator, GearPair, str or path
        Of the piecewise linear model, within the bound of Eq. (8); or a TOML file of a machine in its own units.
    departures : int
        Random departures from which motions are sought, 1 to 100,000.
    seed : int
        Of these.

    Returns
    -------
    ProvenOrbits

    Raises
    ------
    InvalidJob
        If an argument is wrong, or the stiffness is infinite. It is a ValueError.
    OutsideDomain
        If the machine lies outside the domain of the model, or beyond the bound of Eq. (8).
    ImportError
        If python-flint is not there, which the extra ``proof`` brings.

    Examples
    --------
    >>> import rattle
    >>> from rattle_kernels import Oscillator
    >>> found = rattle.prove_orbits(Oscillator(damping=0.6, eccentricity=0.1, half_backlash=0.6, stiffness=1e5))
    >>> found.contact.proven, [(orbit.name, orbit.proven) for orbit in found.orbits]
    (True, [('P(1,1,0)', True), ('P(1,2,0)', True), ('P(2,2,1)', True)])
    """
    oscillator = machine if isinstance(machine, Oscillator) else GearPair.of(machine).oscillator
    if not np.isfinite(oscillator.stiffness):
        raise InvalidJob("only the piecewise linear model is proven here: give a finite stiffness", ("machine",))
    if isinstance(departures, bool) or not isinstance(departures, int) or not 1 <= departures <= 100_000:
        raise InvalidJob(f"departures must be a whole number from 1 to 100000, not {departures!r}", ("departures",))
    oscillator = check_domain(oscillator)
    if importlib.util.find_spec("flint") is None:
        raise ImportError("proving orbits needs python-flint: pip install 'gear-rattle[proof]'")
    from rattle_proof.stiffness.contact import StiffMachine  # loads python-flint
    from rattle_proof.verification.targets.quiet import acceleration_at_rest

    with _digits():
        stiff = StiffMachine(oscillator)
        if acceleration_at_rest(stiff.freeplay).failures:
            raise InvalidJob("a(t) > 0 (Eq. 8) is not proven: the machine is too near to the bound", ("machine",))
        contact = _contact(stiff)
        motions = [each for each in _motions(oscillator, departures, seed) if each.kind != _QUIET]
        orbits = tuple(_orbit(stiff, oscillator, each) for each in motions)
    return ProvenOrbits({name: oscillator.value_of(name) for name in oscillator.parameters}, contact, orbits)


_QUIET = AttractorKind.PERMANENT_CONTACT


@contextmanager
def _digits() -> Iterator[None]:
    from flint import ctx

    before, ctx.prec = ctx.prec, _BITS
    try:
        yield
    finally:
        ctx.prec = before


def _motions(oscillator: Oscillator, departures: int, seed: int) -> tuple[Attractor, ...]:
    random = np.random.default_rng(seed)
    fastest = 1.3 * largest_grazing_speed(oscillator)
    t, v = random.random(departures), fastest * (1.0 - random.random(departures))
    landed = next_impacts(oscillator, t, v, _SETTLED, shortcuts=True)
    on = landed.outcome == Outcome.RETURNED
    return find_attractors(oscillator, landed.t[on][:_SEARCHED], landed.v[on][:_SEARCHED])


def _contact(machine: "StiffMachine") -> ProvenContact:
    from rattle_proof.stiffness.impact_map import NotProven
    from rattle_proof.stiffness.permanent_contact import permanent_contact

    try:
        found = permanent_contact(machine)
    except NotProven as why:
        return ProvenContact(False, str(why))
    return ProvenContact(True, "", found.depth, found.velocity, found.decay)


def _orbit(machine: "StiffMachine", oscillator: Oscillator, motion: Attractor) -> ProvenOrbit:
    from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit
    from rattle_proof.enclosures.orbit_disc import eigenframe
    from rattle_proof.stiffness.impact_map import NotProven
    from rattle_proof.stiffness.orbit_disc import ProvenDisc, largest_disc

    if motion.kind != AttractorKind.PERIODIC:
        return ProvenOrbit(motion.name, False, "it is no periodic orbit")
    if motion.upper_contacts > _LONGEST:
        return ProvenOrbit(motion.name, False, f"its period of {motion.upper_contacts} impacts is too long")
    scale = largest_grazing_speed(oscillator)
    start = float(motion.time[0]), float(motion.velocity[0])
    orbit = find_periodic_orbit(oscillator, *start, motion.upper_contacts, scale)
    if orbit is None:
        return ProvenOrbit(motion.name, False, "Newton's method does not come to it")
    best: ProvenDisc | None = None
    reason = ""
    for place in range(orbit.upper_contacts):
        (a, b), (c, d) = eigenframe(orbit, place, scale).tolist()
        try:
            found = largest_disc(machine, orbit, place, ((a, b), (c, d)))
        except NotProven as why:
            reason = reason or str(why)
            continue
        if best is None or found.disc.radius > best.disc.radius:
            best = found
    if best is None:
        return ProvenOrbit(motion.name, False, reason)
    disc = best.disc
    name = f"P({best.periods},{disc.impacts},{best.lower_contacts})"
    return ProvenOrbit(
        name, True, "", disc.t, disc.v, disc.frame, disc.radius, best.apart, best.contraction, best.slowest
    )


def _not(why: str) -> str:
    return f"not proven, as {why}"


def _down(number: float) -> str:
    """A lower bound, rounded down."""
    shown = f"{number:.3g}"
    return shown if float(shown) <= number else f"{np.nextafter(number, 0.0) * (1 - 5e-3):.3g}"
