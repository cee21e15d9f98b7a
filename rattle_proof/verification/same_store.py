"""The certificate is about this store: its machines, its motions, and what it counts."""

from collections.abc import Iterator

import numpy as np
from flint import arb

from rattle_kernels import Attractor, AttractorKind
from rattle_proof.request import asked_of
from rattle_proof.verification.claims import RATTLES, Lattice
from rattle_proof.verification.ends import in_disc
from rattle_proof.verification.machine import cover, holds
from rattle_proof.verification.moving import box
from rattle_proof.verification.samples import WHOLE
from rattle_proof.verification.verdict import Failure, Part, contradicted
from rattle_proof.verification.work import Subject

# How much a share may differ from what is counted: a mean of doubles is rounded.
_ROUNDED = 1e-12


def same_store(subject: Subject) -> Part:
    """Compare what the certificate says of the store with the store.

    Parameters
    ----------
    subject : Subject

    Returns
    -------
    Part
    """
    checks = [_machine(subject), _parts(subject), _motions(subject), _counts(subject), *_discs(subject)]
    part = Part("the certificate is about this store", len(checks))
    for failure in checks:
        part.add(1, [] if failure is None else [failure])
    return part


def _machine(subject: Subject) -> Failure | None:
    """Every machine that the store was asked for is one of the certificate's."""
    job, machine = subject.proof.job, subject.claims.machine
    if not holds(machine, job.oscillator):
        return contradicted("machine", "the oscillator of the store is none of the certificate's")
    asked = asked_of(job)
    tolerances = asked.tolerances if asked is not None else {}
    # Parameters are intervals: those that hold both ends of each tolerance hold all that lies between.
    for name, ends in tolerances.items():
        if not all(holds(machine, job.oscillator.at(**{name: end})) for end in ends):
            return contradicted("machine", f"{name} has a wider tolerance in the store than in the certificate")
    return None


def _parts(subject: Subject) -> Failure | None:
    covered = cover(subject.claims.parts, subject.claims.machine)
    return None if covered else contradicted("parts", "some machine belongs to no part")


def _motions(subject: Subject) -> Failure | None:
    claims, attractors = subject.claims, subject.proof.attractors
    names = tuple(each.name for each in attractors)
    kinds = dict(enumerate(each.kind for each in attractors))
    right = names == claims.motions
    right &= claims.core is None or kinds.get(claims.core.motion) == AttractorKind.PERMANENT_CONTACT
    if not right:
        return contradicted("motions", f"the store has {', '.join(names)}")
    if claims.rattling is None or claims.rattling.ends.max() == RATTLES:
        return None
    chaos = int(claims.rattling.ends.max()) - 1
    inside = [each.name for n, each in enumerate(attractors) if n != chaos and _visits(each, claims.rattling)]
    return contradicted("motions", f"the rattling set holds departures of {inside[0]}") if inside else None


def _visits(motion: Attractor, lattice: Lattice) -> bool:
    """Whether a motion of the store has a departure in a box of a set."""
    rows, columns = lattice.ends.shape
    for t, v in zip(motion.time.tolist(), motion.velocity.tolist(), strict=True):
        row = int(v // lattice.height) - lattice.first
        if 0 <= row < rows and lattice.ends[row, int(t % 1.0 * columns) % columns]:
            return True
    return False


def _counts(subject: Subject) -> Failure | None:
    """What the certificate counts is what lies in the store."""
    proof, lattice = subject.proof, subject.proof.arrays["ends"]
    counts, shares = proof.certificate.get("counts"), proof.certificate.get("shares")
    if counts is None or shares is None:
        return None
    found = {
        "cells": proof.proven.size,
        "whole": int((proof.proven == WHOLE).sum()),
        "boxes": lattice.size,
        "proven_boxes": int(np.count_nonzero(lattice)),
        "rounds": int(proof.arrays["rounds"].max()),
    }
    for name, count in found.items():
        if counts.get(name) != count:
            return contradicted("counts", f"{name}: {counts.get(name)} in the certificate, {count} in the store")
    if failure := _within(subject) or _never_quiet(subject):
        return failure
    parts = np.bincount(proof.solution.ravel(), proof.proven.ravel(), len(proof.attractors))
    if len(shares) != len(parts) or not np.allclose(shares, parts / (WHOLE * proof.proven.size), 0.0, _ROUNDED):
        return contradicted("shares", "the certificate has other shares than the cells of the store")
    return None


def _within(subject: Subject) -> Failure | None:
    """After how many impacts all that falls quiet lies in the core: what a cell takes, and each round of its boxes."""
    proof = subject.proof
    told = (proof.certificate["quiet"] or {}).get("within")
    if told is None:
        # A store of an earlier edition claims nothing of the kind.
        return None
    quiet = proof.arrays["ends"] == subject.claims.quiet
    impacts = proof.certificate["impacts"]
    most = impacts["cell"] + impacts["trail"] * int(proof.arrays["rounds"].max(where=quiet, initial=0))
    return None if told >= most else contradicted("counts", f"within {told} impacts: it may take {most}")


def _never_quiet(subject: Subject) -> Failure | None:
    """What is claimed never to fall quiet is what is counted so, and all that ends in a motion that rattles."""
    proof, core = subject.proof, subject.claims.core
    share = float(proof.never_quiet.sum(dtype=np.int64)) / (WHOLE * proof.never_quiet.size)
    told = proof.certificate.get("never_quiet")
    if told is None and share == 0.0:
        # A store of the first edition claims nothing of the kind.
        return None
    if told is None or abs(share - told) > _ROUNDED:
        return contradicted("counts", f"never_quiet: {told} in the certificate, {share} in the store")
    rattles = np.ones(proof.solution.shape, np.bool_) if core is None else proof.solution != core.motion
    right = proof.never_quiet + np.where(rattles, 0, proof.proven) <= WHOLE
    right &= ~rattles | (proof.never_quiet >= proof.proven)
    if right.all():
        return None
    row, column = np.argwhere(~right)[0].tolist()
    return contradicted(
        f"cell ({row}, {column})", "as many parts of it as are claimed cannot rattle and end as coloured"
    )


def _discs(subject: Subject) -> Iterator[Failure | None]:
    """Each disc holds a departure of its motion."""
    attractors = subject.proof.attractors
    for disc in subject.claims.discs:
        orbit = attractors[disc.motion] if 0 <= disc.motion < len(attractors) else None
        held = orbit is not None and any(
            in_disc(disc, box(arb(t), arb(v))) for t, v in zip(orbit.time, orbit.velocity, strict=True)
        )
        place = f"disc around t = {disc.t!r}, v = {disc.v!r}"
        yield None if held else contradicted(place, "no departure of its motion in the store lies inside")
