"""A run as tables and as a picture, another processor's beside it."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from matplotlib.figure import Figure
from rich.box import SIMPLE_HEAD
from rich.table import Table

from benchmarks.suite.report import Failed, Measured, Missing, Run

_MARKS = "osD^v"
# Of the longest name of a method: tables of all workloads align.
_WIDTH = 23


def tables(run: Run, beside: Run | None = None) -> Iterator[str | Table]:
    """A line and a table for each workload, a row for each method.

    Parameters
    ----------
    run : Run
    beside : Run, optional
        Adds columns of its rates, and of how many times those this run's are.

    Yields
    ------
    str or rich.table.Table
    """
    runs = [run, beside] if beside else [run]
    for workload, results in run.workloads.items():
        yield f"{workload}: {results.definition}"
        shown = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
        shown.add_column("method", min_width=_WIDTH)
        for heading in (f"{results.unit}/s", "x plain", "error", *(("beside", "ratio") if beside else ())):
            shown.add_column(heading, justify="right")
        for method in _methods(runs, workload):
            mine, other = (each.measured(workload, method) for each in (run, beside or run))
            ratio = mine.units_per_second / other.units_per_second if mine and other else None
            cells = [*_cells(results.methods.get(method)), _rate(other), _times(ratio)]
            shown.add_row(method, *cells[: len(shown.columns) - 1])
        yield shown


def _cells(told: Measured | Missing | Failed | None) -> list[str]:
    """Rate, rate as a multiple of the plain method's, and error; or why there are none."""
    if not isinstance(told, Measured):
        return [_why_not(told), "", ""]
    return [_rate(told) if told.agrees else _why_not(told), _times(told.times_plain), f"{told.error:.0e}"]


def _times(ratio: float | None) -> str:
    return "" if ratio is None else f"{ratio:.3g}"


def _rate(told: Measured | None) -> str:
    """Three digits of a rate, the others zeros."""
    return "" if told is None else f"{float(f'{told.units_per_second:.3g}'):,.0f}"


def draw(runs: Sequence[Run], path: Path) -> None:
    """Units per second by workload and method, on a logarithmic axis, one series for each run.

    Parameters
    ----------
    runs : sequence of Run
        The first decides which workloads there are.
    path : Path
        Of the PNG.
    """
    rows = {workload: _methods(runs, workload) for workload in runs[0].workloads}
    rates = [each.units_per_second for run in runs for each in _all_measured(run, rows)] or [1.0]
    heights = [len(methods) + 1.0 for methods in rows.values()]
    figure = Figure(figsize=(8.0, 1.2 + 0.32 * sum(heights)), layout="constrained")
    panels = figure.subplots(len(rows), squeeze=False, gridspec_kw={"height_ratios": heights}, sharex=True)[:, 0]
    for panel, (workload, methods) in zip(panels, rows.items(), strict=True):
        panel.set(xscale="log", xlim=(min(rates) / 2, max(rates) * 2), ylim=(len(methods) - 0.4, -0.6))
        for number, run in enumerate(runs):
            found = [run.measured(workload, method) for method in methods]
            speeds = [each.units_per_second if each else math.nan for each in found]
            panel.plot(speeds, range(len(methods)), _MARKS[number % len(_MARKS)], label=run.machine)
        panel.set_yticks(range(len(methods)), [_label(runs[0], workload, method) for method in methods])
        panel.grid(axis="x", alpha=0.4)
        unit = runs[0].workloads[workload].unit
        panel.set_title(workload if workload == unit else f"{workload}: {unit}", loc="left", fontsize="medium")
    panels[-1].set_xlabel("units per second")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=len(runs))
    figure.savefig(path, dpi=120)


def _all_measured(run: Run, rows: dict[str, list[str]]) -> Iterator[Measured]:
    for workload, methods in rows.items():
        yield from filter(None, (run.measured(workload, method) for method in methods))


def _methods(runs: Sequence[Run], workload: str) -> list[str]:
    """Names of those that any run has, in the order of the first."""
    having = (run.workloads[workload] for run in runs if workload in run.workloads)
    return list(dict.fromkeys(method for results in having for method in results.methods))


def _label(run: Run, workload: str, method: str) -> str:
    reason = _why_not(run.workloads[workload].methods.get(method))
    return f"{method} ({reason})" if reason else method


def _why_not(told: Measured | Missing | Failed | None) -> str:
    """Why a method has no rate, empty if it has one."""
    if isinstance(told, Missing):
        return "not installed"
    if isinstance(told, Failed):
        return "failed"
    return "" if told is None or told.agrees else "wrong"
