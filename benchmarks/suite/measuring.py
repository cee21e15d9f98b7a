"""Run methods, time them and check their answers."""

import platform
import subprocess
import time
from collections.abc import Callable, Iterable
from datetime import UTC, datetime
from importlib.metadata import packages_distributions, version
from pathlib import Path

import numpy as np

from benchmarks import processor
from benchmarks.suite.methods import PLAIN, Method
from benchmarks.suite.report import FORMAT, Failed, Measured, Missing, Results, Run
from benchmarks.suite.workloads import WORKLOADS, Workload
from rattle.local import usable_cores

_ROOT = Path(__file__).parents[2]
_VERSIONS = ("gear-rattle", "numpy", "numba", "llvmlite")


def measure(method: Method, workload: Workload, repeat: int, thinner: int = 1) -> Measured:
    """Time a method and check its answer.

    Parameters
    ----------
    method : Method
    workload : Workload
    repeat : int
        Repetitions, at least 1. One before them on a few inputs is not timed: it compiles.
    thinner : int
        One in so many of the method's own inputs are used, a power of five, as long as any are left.

    Returns
    -------
    Measured
        Its answer is that of the last repetition.
    """
    every = min(method.every * thinner, workload.thinnest)
    method.compute(workload.part(max(every, workload.known)))
    inputs, seconds, answer = workload.part(every), [], np.empty(0)
    for _ in range(repeat):
        begin = time.perf_counter()
        answer = method.compute(inputs)
        seconds.append(time.perf_counter() - begin)
    units = workload.items(inputs) * workload.units_of_item
    error = workload.error(answer, every)
    return Measured(
        cores=method.cores, every=every, units=units, seconds=seconds, error=error, allowed=workload.allowed
    )


def measure_all(
    methods: Iterable[Method], repeat: int, *, thinner: int = 1, report: Callable[[Method], None] = lambda _: None
) -> Run:
    """Run methods one after the other.

    Parameters
    ----------
    methods : iterable of Method
    repeat : int
    thinner : int
        As in `measure`.
    report : callable
        Called with each method before it runs.

    Returns
    -------
    Run

    Raises
    ------
    ValueError
        If inputs are not those of their checksum.
    """
    methods = list(methods)
    results: dict[str, Results] = {}
    for workload in WORKLOADS.values():
        mine = [each for each in methods if each.workload == workload.name]
        if not mine:
            continue
        workload.check_inputs()
        found: dict[str, Measured | Missing | Failed] = {}
        for method in mine:
            report(method)
            found[method.name] = _told(method, workload, repeat, thinner)
        _compare(found)
        results[workload.name] = Results(
            definition=workload.definition, unit=workload.unit, sha256=workload.sha256, methods=found
        )
    names = packages_distributions()
    needed = {names[package][0] for each in methods for package in each.needs if package in names}
    return Run(
        format=FORMAT,
        date=datetime.now(UTC).date().isoformat(),
        processor=processor(),
        cores=usable_cores(),
        python=platform.python_version(),
        versions={package: version(package) for package in (*_VERSIONS, *sorted(needed))},
        commit=_commit(),
        workloads=results,
    )


def _told(method: Method, workload: Workload, repeat: int, thinner: int) -> Measured | Missing | Failed:
    if method.missing:
        return Missing(not_installed=method.missing)
    try:
        return measure(method, workload, repeat, thinner)
    except Exception as error:  # of others' code: the methods after it run all the same
        return Failed(failed=f"{type(error).__name__}: {error}")


def _compare(found: dict[str, Measured | Missing | Failed]) -> None:
    """Set rates as multiples of the plain method's, if that has run and is right."""
    plain = found.get(PLAIN)
    for each in found.values():
        if isinstance(plain, Measured) and plain.agrees and isinstance(each, Measured) and each.agrees:
            each.times_plain = each.units_per_second / plain.units_per_second


def _commit() -> str | None:
    command = ["git", "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        return subprocess.run(command, cwd=_ROOT, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return None
