"""The parts of the theorem, one after the other."""

from collections.abc import Callable
from typing import Literal

import numpy as np

from rattle.results.cache import cache
from rattle_proof.verification.kept import Kept, content_of
from rattle_proof.verification.same_store import same_store
from rattle_proof.verification.samples import WHOLE
from rattle_proof.verification.targets.quiet import COLUMNS, acceleration_at_rest
from rattle_proof.verification.verdict import Part, Verification
from rattle_proof.verification.work import Crew, Subject, subject_at

Counting = Callable[[str, int, int], None]
Count = int | Literal["all"]

_MOST_AT_A_TIME, _BATCHES = 50, 64


def prove_again(
    location: str, cells: Count, boxes: Count, seed: int, processes: int, anew: bool, progress: Counting
) -> Verification:
    """All parts of the theorem for one store; see `rattle.verify`."""
    subject = subject_at(location)
    random, content = np.random.default_rng(seed), content_of(subject.proof)
    parts = [same_store(subject), acceleration_at_rest(subject.claims.machine)]
    with Crew(subject, location, processes) as crew:
        for what, part, places in [*_targets(subject), *_tried_one_by_one(subject, cells, boxes, random)]:
            kept = Kept(cache.beside / "verified", content, what, places)
            if anew:
                kept.forget()
            _try_all(crew, kept, what, part, places, progress)
            parts.append(part)
    return Verification(location, tuple(parts))


def _try_all(crew: Crew, kept: Kept, what: str, part: Part, places: np.ndarray, progress: Counting) -> None:
    """Try what has not been tried, and count all."""
    size = max(1, min(_MOST_AT_A_TIME, len(places) // _BATCHES))
    batches = {n: places[i : i + size] for n, i in enumerate(range(0, len(places), size))}
    found = kept.read()
    part.earlier = done = sum(len(batches[n]) for n in found)
    name = f"{part.name} (resumed)" if found else part.name
    progress(name, done, len(places))
    for n, failures in crew.try_all(what, {n: batch for n, batch in batches.items() if n not in found}):
        kept.add(n, failures)
        found[n] = failures
        done += len(batches[n])
        progress(name, done, len(places))
    # In their order: the answer is the same whoever was faster, and wherever it was stopped.
    for n, batch in batches.items():
        part.add(len(batch), found[n])


def _targets(subject: Subject) -> list[tuple[str, Part, np.ndarray]]:
    claims, found = subject.claims, []
    if claims.discs:
        places = np.argwhere(np.ones((len(claims.discs), 1)))
        found.append(("discs", Part("discs around periodic orbits", len(places)), places))
    if claims.core is not None:
        places = np.argwhere(np.ones((len(claims.parts), COLUMNS)))
        found.append(("core", Part(f"quiet core, level {claims.core.level:.6g}", len(places)), places))
    return found


def _tried_one_by_one(
    subject: Subject, cells: Count, boxes: Count, random: np.random.Generator
) -> list[tuple[str, Part, np.ndarray]]:
    claims, found = subject.claims, []
    if claims.rattling is not None:
        places = np.argwhere(claims.rattling.ends)
        chosen = places if boxes == "all" else _some(places, boxes, random)
        found.append(("rattling", Part("boxes that rattle for ever", len(places)), chosen))
    if claims.windows:
        places = np.argwhere(subject.proof.arrays["window_ends"])
        found.append(("windows", Part("boxes of windows", len(places)), _some(places, boxes, random)))
    chosen, of = _boxes(subject.proof.arrays, boxes, random)
    found.append(("boxes", Part("boxes of the lattice", of), chosen))
    proof = subject.proof
    places = _rattling_boxes(proof.arrays)
    if places.size:
        chosen = _some(places, boxes, random)
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


def _some(places: np.ndarray, count: Count, random: np.random.Generator) -> np.ndarray:
    if count == "all":
        return places
    return places[np.sort(random.permutation(len(places))[:count])]


def _rattling_boxes(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """Boxes that never fall quiet and have no end: the others are proven by that."""
    if "never_quiet" not in arrays:
        return np.empty((0, 2), np.int64)
    return np.argwhere((arrays["never_quiet"] > 0) & (arrays["ends"] == 0))


def _boxes(arrays: dict[str, np.ndarray], count: Count, random: np.random.Generator) -> tuple[np.ndarray, int]:
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
