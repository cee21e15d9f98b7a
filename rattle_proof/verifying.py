"""What a store claims to be proven is proven again."""

import importlib.util
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from rattle_proof.verification.verdict import Verification


def verify(
    store: str | Path,
    *,
    cells: int | Literal["all"] = 10_000,
    boxes: int | Literal["all"] = 10_000,
    seed: int = 0,
    processes: int = 1,
    anew: bool = False,
    progress: Callable[[str, int, int], None] = lambda what, done, total: None,
) -> "Verification":
    """Prove again what a basin's store claims to be proven, by other means: Arb balls of python-flint.

    These are proven whole: a(t) > 0, the quiet core, each disc around an orbit. Of the cells, of the boxes of the
    lattice by which they were proven, and of those of the set that rattles for ever, a random sample is tried. A sample
    is a sample: the others are not looked at. If all boxes are right, so are the set, and the lattice, by induction
    over its rounds.

    What was tried is kept in `rattle.cache`. So the same call goes on where it stopped, and gives the same answer. All
    is tried again where the store, the sample or the code that verifies is another.

    Parameters
    ----------
    store : str or path
        A folder, or ``s3://bucket/prefix``, of a finished basin that was computed with a proof.
    cells : int or "all"
        How many cells are tried, of those with a proven part.
    boxes : int or "all"
        How many boxes of the lattice are tried, as many of each round as there are; and how many of the set that
        rattles for ever.
    seed : int
        Of the sample.
    processes : int
        How many processes work; with more than one, a script needs ``if __name__ == "__main__"``.
    anew : bool
        Try also what earlier runs have tried.
    progress : callable
        Called with what is being proven, how much of it has been, and of how much.

    Returns
    -------
    Verification

    Raises
    ------
    StoreConflict
        If there is no finished basin with a proof.
    StoreFailed
        If it cannot be read.
    ImportError
        If python-flint is not there, which the extra ``proof`` brings.

    Examples
    --------
    >>> import rattle
    >>> basin = rattle.basin(damping=1.5, cells=20, prove=True, store="damped.zarr", progress=False)
    >>> found = rattle.verify("damped.zarr", cells=10, boxes=100)
    >>> found.holds, [(part.name, part.tried) for part in found.parts[-2:]]
    (True, [('boxes of the lattice', 100), ('cells', 10)])
    """
    if importlib.util.find_spec("flint") is None:
        raise ImportError("verifying needs python-flint: pip install 'gear-rattle[proof]'")
    from rattle_proof.verification.checking import prove_again  # loads python-flint, Numba and Zarr

    return prove_again(str(store), cells, boxes, seed, processes, anew, progress)
