"""The parts of the theorem, one after the other."""

from collections.abc import Callable
from functools import partial
from typing import Literal

import numpy as np

from rattle_proof.verification.same_store import same_store
from rattle_proof.verification.samples import WHOLE
from rattle_proof.verification.targets.discs import discs
from rattle_proof.verification.targets.quiet import COLUMNS, acceleration_at_rest
from rattle_proof.verification.verdict import Part, Verification
from rattle_proof.verification.work import Crew, Subject, subject_at

Counting = Callable[[str, int, int], None]


def prove_again(
    location: str, cells: int, boxes: int | Literal["all"], seed: int, processes: int, progress: Counting
) -> Verification:
    """All parts of the theorem for one store; see `rattle.verify`."""
    subject = subject_at(location)
    random = np.random.default_rng(seed)
    parts = _targets(subject)
    with Crew(subject, location, processes) as crew:
        for what, part, places in [*_core(subject), *_tried_one_by_one(subject, cells, boxes, random)]:
            for tried, failures in crew.try_all(what, places, partial(progress, what)):
                part.add(tried, failures)
            parts.append(part)
    return Verification(location, tuple(parts))


def _targets(subject: Subject) -> list[Part]:
    claims = subject.claims
    parts = [same_store(subject), acceleration_at_rest(claims.machine)]
    return [*parts, discs(claims)] if claims.discs else parts


def _core(subject: Subject) -> list[tuple[str, Part, np.ndarray]]:
    claims = subject.claims
    if claims.core is None:
        return []
    places = np.argwhere(np.ones((len(claims.parts), COLUMNS)))
    return [("core", Part(f"quiet core, level {claims.core.level:.6g}", len(places)), places)]


def _tried_one_by_one(
    subject: Subject, cells: int, boxes: int | Literal["all"], random: np.random.Generator
) -> list[tuple[str, Part, np.ndarray]]:
    claims, found = subject.claims, []
    if claims.rattling is not None:
        places = np.argwhere(claims.rattling.ends)
        found.append(("rattling", Part("set that rattles for ever: its boxes", len(places)), places))
    chosen, of = _boxes(subject.proof.arrays, boxes, random)
    found.append(("boxes", Part("boxes of the lattice", of), chosen))
    proof = subject.proof
    places = _rattling_boxes(proof.arrays)
    if places.size:
        chosen = places if boxes == "all" else _some(places, boxes, random)
        # Those of rest, which do not belong there, are few: all are looked at.
        rest = places[places[:, 0] % claims.lattice.ends.shape[0] == 0]
        chosen = np.unique(np.concatenate([rest, chosen]), axis=0)
        found.append(("rattling boxes", Part("boxes that never fall quiet", len(places)), chosen))
    # Where all of a cell is proven to end in a motion, that is tried below.
    rattling = np.argwhere((proof.never_quiet > 0) & (proof.proven < WHOLE))
    if rattling.size:
        part = Part("cells that never fall quiet", len(rattling))
        found.append(("rattling cells", part, _some(rattling, cells, random)))
    proven = np.argwhere(proof.proven > 0)
    found.append(("cells", Part("cells", len(proven)), _some(proven, cells, random)))
    return found


def _some(places: np.ndarray, count: int, random: np.random.Generator) -> np.ndarray:
    return places[np.sort(random.permutation(len(places))[:count])]


def _rattling_boxes(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """Boxes that never fall quiet and have no end: the others are proven by that."""
    if "never_quiet" not in arrays:
        return np.empty((0, 2), np.int64)
    return np.argwhere((arrays["never_quiet"] > 0) & (arrays["ends"] == 0))


def _boxes(
    arrays: dict[str, np.ndarray], count: int | Literal["all"], random: np.random.Generator
) -> tuple[np.ndarray, int]:
    """A sample of the proven boxes, in which rounds have equal shares as far as they can; and of how many."""
    ends, rounds = arrays["ends"].ravel(), arrays["rounds"].ravel()
    proven = np.flatnonzero(ends)
    if count != "all" and count < len(proven):
        shuffled = random.permutation(proven)
        order = np.argsort(rounds[shuffled], kind="stable")
        shuffled = shuffled[order]
        # The rank of each within its round: the first of each round come first.
        begins = np.searchsorted(rounds[shuffled], rounds[shuffled], side="left")
        rank = np.arange(len(shuffled)) - begins
        chosen = np.sort(shuffled[np.argsort(rank, kind="stable")[:count]])
    else:
        chosen = proven
    return np.stack(np.unravel_index(chosen, arrays["ends"].shape), axis=1), len(proven)
