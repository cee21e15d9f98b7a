"""The verbs: what is computed here, in threads of this process."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import xarray as xr
from rich.console import Console

from rattle.argument import Argument
from rattle.arguments import demand_known, demand_names, job_of
from rattle.loading import without_collections
from rattle.progress import progress_line, shows_bars
from rattle.results.kept import cache
from rattle.results.opening import open
from rattle.results.trajectories import TRAJECTORY_EXAMPLE, dataset_of, trajectory_arguments, trajectory_request
from rattle.verb import VERBS, Verb, described
from rattle_kernels.numerics.fused_multiply_add import fuses_multiply_add
from worker.estimate import estimate
from worker.jobs.job import Job
from worker.kinds import KINDS
from worker.progress import Report
from worker.stores.opening import is_complete

_LARGE_SECONDS = 60.0
_HERE = (
    Argument("store", str | Path | None, None, "Where the result lies; by default in `rattle.cache`"),
    Argument("workers", int | None, None, "Threads; by default one for each core"),
    Argument("scheduler", str | None, None, "Address of a Dask scheduler, in place of threads"),
    Argument(
        "progress", bool | Report, True,
        "Whether progress is shown on a terminal and in a notebook; or a function, called with each `Progress`",
    ),
)  # fmt: skip


def compute(
    job: Job,
    *,
    store: str | Path | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: bool | Report = True,
) -> xr.Dataset:
    """Compute a job here, or open its result if it is there already.

    Parameters
    ----------
    job : Job
    store : str or path, optional
        Where the result lies: a folder, or ``s3://bucket/prefix``. By default in `rattle.cache`.
    workers : int, optional
        Threads; by default one for each core.
    scheduler : str, optional
        Address of a Dask scheduler, in place of threads.
    progress : bool or callable
        Whether progress is shown on a terminal and in a notebook. Or a function that is called with each `Progress`,
        in another thread; an exception that it raises stops the work.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    JobCancelled
        If it was interrupted. The same call goes on from what is in the store.
    StoreConflict
        If the store is another request's.
    StoreFailed, TileFailed, ClusterFailed, NotFound

    Examples
    --------
    >>> import rattle
    >>> job = rattle.BasinJob(grid={"time": {"cells": 20}, "velocity": {"cells": 20}}, iterations=101)
    >>> rattle.compute(job, progress=False).rattle.complete
    True
    """
    location = cache.location_of(job) if store is None else str(store)
    if workers is not None and workers < 1:
        raise ValueError(f"workers must be 1 or more, not {workers}")
    if not is_complete(location, job.digest):
        with without_collections():
            from rattle.here import run_here  # loads Dask, which a result that is kept does without

            fuses_multiply_add()  # Numba loads half of itself, and SciPy, when a first kernel is called

        where: dict[str, Any] = {"workers": workers, "scheduler": scheduler}
        if callable(progress):
            run_here(job, location, progress, **where)
        else:
            console = _console(progress)
            if not console.quiet:
                _announce(job, workers, console)
            with progress_line(console, KINDS[job.kind].unit) as line:
                run_here(job, location, line.report, compiling=line.compiling, **where)
    return open(location)


def _announce(job: Job, workers: int | None, console: Console) -> None:
    """Say what large work takes, before it begins."""
    from rattle.here import usable_cores

    expected = estimate(job, workers or usable_cores())
    if expected.seconds > _LARGE_SECONDS:
        console.print(f"this takes {expected}", highlight=False)


def _console(progress: bool) -> Console:
    """Where progress is shown: nowhere, if no bar can be."""
    console = Console(stderr=True)
    return console if progress and shows_bars(console) else Console(quiet=True)


def _verb(verb: Verb) -> Callable[..., xr.Dataset]:
    job_class, own = KINDS[verb.kind].job_class, [each.name for each in _HERE]

    def call(*positional: Any, **given: Any) -> xr.Dataset:
        demand_names(verb.name, positional, verb.arguments)
        demand_known(verb.name, given, [each.name for each in (*verb.arguments, *_HERE)])
        described_by = {name: value for name, value in given.items() if name not in own}
        options = {name: value for name, value in given.items() if name in own}
        return compute(job_of(job_class, described_by, verb.name), **options)

    return described(call, verb.name, verb.summary, (*verb.arguments, *_HERE), verb.returns, verb.example)


basin, sweep, bifurcation, orbits, manifolds, grazing_curve = (_verb(verb) for verb in VERBS)


def _follow(*positional: Any, **given: Any) -> xr.Dataset:
    demand_names("trajectory", positional, trajectory_arguments())
    request = trajectory_request(given)
    return dataset_of(request, request.follow())


trajectory = described(_follow, "trajectory", *TRAJECTORY_EXAMPLE[:1], trajectory_arguments(), *TRAJECTORY_EXAMPLE[1:])
