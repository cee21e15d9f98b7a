"""Chaos that is chaos: by proof."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rattle_kernels import Attractor, Oscillator, Outcome, find_attractors, largest_grazing_speed, next_impacts
from worker.errors import InvalidJob
from worker.gear_pair import GearPair

_DRAWN, _SETTLED, _SEARCHED = 400, 2000, 64


@dataclass(frozen=True)
class ProvenChaos:
    """What is proven of a chaotic motion, for every machine within the tolerances.

    Attributes
    ----------
    oscillator : dict
        The machine in the model.
    tolerances : dict of str to (float, float)
    boxes, columns : int
        The set that is never left: so many boxes, each ``1/columns`` of a period wide.
    entropy : float
        Topological entropy of P on the set, for an impact and in nats, at least; 0 if none is shown.
    growth : (int, int)
        Numerator and denominator of its exponential: so many times as many motions are told apart with each impact.
    leaves : int
        Curves across the set that show it.
    repelling : int
        Cycles of the set repel, up to so many impacts.
    longest : int
        Up to how many were looked for.
    """

    oscillator: dict[str, Any]
    tolerances: dict[str, tuple[float, float]]
    boxes: int
    columns: int
    entropy: float
    growth: tuple[int, int]
    leaves: int
    repelling: int
    longest: int

    def to_dict(self) -> dict[str, Any]:
        """All of it, for JSON.

        Returns
        -------
        dict
        """
        return asdict(self)

    def __str__(self) -> str:
        """In sentences."""
        # Rounded down: it is a lower bound.
        entropy = math.floor(self.entropy * 1e4) / 1e4
        lines = [
            f"never left: a set of {self.boxes:,} boxes, each 1/{self.columns} of a period wide",
            f"topological entropy: at least {entropy:.4f} for an impact, from {self.leaves} leaves"
            if self.entropy > 0.0
            else "topological entropy: no bound above 0 is shown",
        ]
        if self.longest:
            told = f"no cycle of up to {self.repelling} impacts attracts"
            lines.append(told if self.repelling == self.longest else f"{told}; longer ones are not decided")
        return "\n".join(lines)


def prove_chaos(
    machine: GearPair | Oscillator | str | Path,
    *,
    tolerances: Mapping[str, tuple[float, float]] | None = None,
    columns: int = 2048,
    leaves: int = 200,
    cycles: int = 3,
    seed: int = 0,
) -> ProvenChaos:
    """Prove that a machine's chaotic motion is chaos: its topological entropy is positive, and short cycles repel.

    A chaotic motion is sought by numbers. Of a set of boxes around it that P maps into itself, a lower bound of the
    entropy is proven, and that none of its short cycles attracts. Longer cycles may: then what looks chaotic is
    periodic in the end, after transients that are chaotic by this proof.

    Parameters
    ----------
    machine : Oscillator, GearPair, str or path
        Of the impacting model, within the bound of Eq. (8); or a TOML file of a machine in its own units.
    tolerances : mapping of str to (float, float), optional
        Least and greatest value of parameters: what is proven holds for every machine within.
    columns : int
        Boxes for a period, at least: a power of two from 256 to 8192. If they are too few for a set, more are tried.
    leaves : int
        Curves across the set that are tried. More of them show a little more of the entropy.
    cycles : int
        Impacts of the longest cycles that are looked at, 0 to 8. Each more takes some ten times as long.
    seed : int
        Of the departures from which a chaotic motion is sought.

    Returns
    -------
    ProvenChaos

    Raises
    ------
    InvalidJob
        If an argument is wrong, no chaotic motion is found, or no set around it is mapped into itself. It is a
        ValueError.
    OutsideDomain
        If Eq. (8) cannot be proven for all machines within.

    Examples
    --------
    >>> import rattle
    >>> from rattle_kernels import Oscillator
    >>> found = rattle.prove_chaos(Oscillator(damping=0.6, eccentricity=0.1, half_backlash=0.6), cycles=2)
    >>> found.entropy > 0.5, found.repelling
    (True, 2)
    """
    oscillator = machine if isinstance(machine, Oscillator) else GearPair.of(machine).oscillator
    _check(oscillator, columns, leaves, cycles)
    within = dict(tolerances or {})
    motion, others = _chaotic_motion(oscillator, seed)
    if motion is None:
        raise InvalidJob(f"no chaotic motion is found: those found are {', '.join(others)}", ("machine",))
    from rattle_proof.chaos.proof import chaos_of  # its kernels take a minute to compile, the first time
    from rattle_proof.enclosures.machine import machine_of
    from rattle_proof.request import ProofRequest, check_proof

    asked = check_proof(ProofRequest(tolerances=within), oscillator, (), None, False)
    proven = chaos_of(machine_of(oscillator, asked.tolerances), motion, columns, leaves, cycles, lambda: None)
    if proven is None:
        raise InvalidJob("no set around the chaotic motion is mapped into itself: it leaks, or tolerances are wide",
                         ("machine",))  # fmt: skip
    growth = proven.growth
    return ProvenChaos(
        {name: oscillator.value_of(name) for name in oscillator.parameters},
        asked.tolerances,
        int(np.count_nonzero(proven.lattice.ends)),
        proven.lattice.ends.shape[1],
        0.0 if growth is None else growth.entropy,
        (1, 1) if growth is None else (growth.numerator, 2**growth.bits),
        0 if proven.leaves is None else len(proven.leaves.times),
        proven.cycles.repel,
        cycles,
    )


def _check(oscillator: Oscillator, columns: int, leaves: int, cycles: int) -> None:
    if math.isfinite(oscillator.stiffness):
        raise InvalidJob("only the impacting model is proven: leave out stiffness", ("machine",))
    wholes = ("columns", columns, 256, 8192), ("leaves", leaves, 8, 2000), ("cycles", cycles, 0, 8)
    for name, value, least, most in wholes:
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            raise InvalidJob(f"{name} must be a whole number from {least} to {most}, not {value!r}", (name,))
    if columns & (columns - 1):
        raise InvalidJob(f"columns must be a power of two, not {columns}", ("columns",))


def _chaotic_motion(oscillator: Oscillator, seed: int) -> tuple[Attractor | None, list[str]]:
    """The chaotic motion that most departures come to, and the names of the others."""
    random = np.random.default_rng(seed)
    fastest = 1.3 * largest_grazing_speed(oscillator)
    t, v = random.random(_DRAWN), fastest * (1.0 - random.random(_DRAWN))
    landed = next_impacts(oscillator, t, v, _SETTLED, shortcuts=True)
    on = landed.outcome == Outcome.RETURNED
    found = find_attractors(oscillator, landed.t[on][:_SEARCHED], landed.v[on][:_SEARCHED])
    chaotic = [each for each in found if each.is_chaotic]
    return (chaotic[0] if chaotic else None), [each.name for each in found]
