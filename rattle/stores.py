"""Whole stores: checked and mended, and exported."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from worker.progress import Report
    from worker.stores.checking.damage import Damage, Findings


@dataclass(frozen=True)
class Check:
    """What a check of a store has found.

    Parameters
    ----------
    store : str
    files : int
        Files that were read.
    damages : tuple of Damage
        What was damaged or missing: each has an ``array``, a ``chunk`` (one tile is one chunk) and ``what``.
    mended : bool
        Whether nothing is damaged any more.
    complete : bool
        Whether the job has finished. An unfinished one goes on with the call that began it.
    """

    store: str
    files: int
    damages: "tuple[Damage, ...]"
    mended: bool
    complete: bool


def check(
    store: str | Path,
    *,
    dry_run: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    reading: Callable[[int, int], None] = lambda done, total: None,
    computing: "Report" = lambda progress: None,
) -> Check:
    """Read every file of a store, and compute anew what is damaged or missing, to the bytes that were there.

    A chunk is damaged if its checksum is wrong, metadata if they are not those that the root says once more. The store
    becomes unfinished first: if the work is interrupted, the next check goes on with it. Nobody else may write to it
    meanwhile. A store that was not finished before is not finished here, but what is damaged is taken out.

    Parameters
    ----------
    store : str or path
        A folder, or ``s3://bucket/prefix``.
    dry_run : bool
        Whether everything stays as it is.
    workers : int, optional
        Threads that compute; by default one for each core.
    scheduler : str, optional
        Address of a Dask scheduler, in place of threads.
    reading : callable
        Called with the number of chunks that have been read, and of all.
    computing : callable
        Called with each `Progress`, in another thread.

    Returns
    -------
    Check

    Raises
    ------
    StoreConflict
        If there is no store, or its request is lost, so that nothing tells what it held.
    StoreFailed
        If it cannot be read or written.
    JobCancelled
        If it was interrupted.

    Examples
    --------
    >>> import rattle
    >>> basin = rattle.basin(cells=20, store="checked.zarr", progress=False)
    >>> rattle.check("checked.zarr").damages
    ()
    """
    from worker.stores.checking.damage import check_store  # loads Numba and Zarr

    found = check_store(str(store), reading)
    mended = not found.damages
    if found.damages and not dry_run:
        _mend(found, workers, scheduler, computing)
        mended = True
    return Check(found.location, found.files, found.damages, mended, found.complete)


def _mend(found: "Findings", workers: int | None, scheduler: str | None, computing: "Report") -> None:
    from worker.stores.checking.damage import invalidate

    invalidate(found)
    if not found.complete:
        return
    from rattle.local import run_here  # loads tasks, which a store without damage does without

    run_here(found.job, found.location, computing, workers=workers, scheduler=scheduler)


def export(
    store: str | Path, path: str | Path, *, creator: str | None = None, license: str | None = None  # noqa: A002
) -> Path:  # fmt: skip
    """Write a finished result as a zipped RO-Crate 1.1: its request, versions, tables and pictures.

    What packages add to a basin is part of it.

    Parameters
    ----------
    store : str or path
        A folder, or ``s3://bucket/prefix``.
    path : str or path
        File to write; its name ends in .zip.
    creator : str, optional
        Who made the result. A store says nobody's name.
    license : str, optional
        SPDX name of the result's licence, by default CC0-1.0.

    Returns
    -------
    Path
        The file, in place of one that was there. The same store gives the same bytes.

    Raises
    ------
    InvalidJob
        If the file's name or the licence cannot be one, or the result is not finished.
    StoreConflict, StoreFailed
        If there is no store, or it cannot be read.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> import rattle
    >>> basin = rattle.basin(cells=20, store="exported.zarr", progress=False)
    >>> rattle.export("exported.zarr", "basin.zip", creator="A. Author").name
    'basin.zip'
    """
    from rattle.crate import write_crate  # loads Numba, Zarr and Matplotlib

    return write_crate(str(store), Path(path), creator, license)
