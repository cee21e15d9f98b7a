"""What has been tried of a part of the theorem is kept, so that a verification goes on where it stopped."""

import hashlib
import json
import warnings
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import flint
import numpy as np

from rattle_proof.stored_proof import StoredProof
from rattle_proof.verification.verdict import Failure
from worker.stores.provenance import versions


class Kept:
    """Batches that were tried, and what failed in each: a file of one line for each of them.

    A line begins with a digest of itself and of all that its verdict rests on. A line that is torn, or of anything
    else, has another digest: it is passed over, and its batch is tried again.

    Parameters
    ----------
    folder : path
    content : str
        Digest of the store (`content_of`).
    what : str
        Part of the theorem.
    places : ndarray of int
        All that is to be tried of it.
    """

    def __init__(self, folder: Path, content: str, what: str, places: np.ndarray) -> None:
        chosen = hashlib.sha256(places.astype(np.int64).tobytes()).hexdigest()
        self._rests_on = " ".join((_code(), content, what, chosen))
        self.file = folder / f"{self._digest('')}.txt"

    def _digest(self, text: str) -> str:
        return hashlib.sha256(f"{self._rests_on} {text}".encode()).hexdigest()[:32]

    def read(self) -> dict[int, list[Failure]]:
        """What failed in each batch that was tried, by its number."""
        try:
            lines = self.file.read_text(errors="replace").splitlines()
        except OSError:
            return {}
        found = {}
        for digest, _, text in (line.partition(" ") for line in lines):
            if digest == self._digest(text):
                number, failures = json.loads(text)
                found[number] = [Failure(*each) for each in failures]
        return found

    def add(self, number: int, failures: Sequence[Failure]) -> None:
        """Keep what failed in a batch."""
        text = json.dumps([number, failures])
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            with self.file.open("a") as file:
                # In front, so that it ends a line that is torn.
                file.write(f"\n{self._digest(text)} {text}")
        except OSError as error:
            warnings.warn(f"what is verified is not kept: {error}", stacklevel=2)

    def forget(self) -> None:
        """Keep nothing of what was tried."""
        self.file.unlink(missing_ok=True)


def content_of(proof: StoredProof) -> str:
    """Digest of all of a store that its cells, boxes and core are proven from."""
    digest = hashlib.sha256(json.dumps([proof.job.request(), proof.certificate], sort_keys=True).encode())
    arrays = [proof.arrays[name] for name in sorted(proof.arrays)]
    for values in (*arrays, proof.solution, proof.proven, proof.never_quiet):
        digest.update(f"{values.dtype.str} {values.shape}".encode())
        digest.update(values.tobytes())
    return digest.hexdigest()


@cache
def _code() -> str:
    """Digest of what verifies: another version is to try all again."""
    digest = hashlib.sha256(json.dumps([versions(), flint.__version__, flint.__FLINT_VERSION__]).encode())
    folder = Path(__file__).parent
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.relative_to(folder).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()
