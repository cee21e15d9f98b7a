"""Picture of periodic orbits: in the (t, v) plane, or over the parameter in which they are followed."""

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle_kernels import BranchEnd, SpecialKind, grazing_velocity
from worker.jobs.orbits_job import OrbitsJob
from worker.pictures.symbols import in_words, oscillator_text
from worker.stores.layout import Columns
from worker.stores.table import slices

_MARKERS = {
    SpecialKind.SADDLE_NODE: "o", SpecialKind.PERIOD_DOUBLING: "s", SpecialKind.GRAZING: "^",
    SpecialKind.CONTACT_LOSS: "v",
}  # fmt: skip


def plot_orbits(axes: Axes, job: OrbitsJob, columns: Columns) -> None:
    """Mark the departures of attracting orbits by x and of others by +, and draw v*(t)."""
    t = np.linspace(0.0, 1.0, 512)
    axes.plot(t, grazing_velocity(job.oscillator, t), color="gray", linewidth=1.0, label="grazing curve")
    for i, name in enumerate(columns["name"]):
        marker, stability = ("x", "attracts") if columns["attracts"][i] else ("+", "unstable")
        axes.plot(
            columns["orbit_time"][i], columns["orbit_velocity"][i], marker, label=f"{name} {stability}", markersize=8
        )
    axes.set_xlabel("time t of departure (forcing periods)")
    axes.set_ylabel("velocity v of departure")


def _mark_lost_ends(axes: Axes, job: OrbitsJob, columns: Columns) -> None:
    """Mark by x where a branch goes on, or may, but is not followed; in the impacting model a graze ends it."""
    assert job.continuation is not None
    lost = [BranchEnd.STALLED, BranchEnd.POINTS]
    if not math.isinf(job.oscillator.stiffness):
        lost.append(BranchEnd.GRAZING)
    names, label = [reason.name.lower() for reason in lost], "not followed further"
    for number, points in enumerate(slices(columns["branch_size"])):
        for end, place in ((0, points.start), (1, points.stop - 1)):
            if columns["branch_end_reason"][number][end] in names:
                speeds = columns["branch_velocity"][place]
                at = np.full(speeds.size, columns[job.continuation.parameter][place])
                axes.plot(at, speeds, "x", color="black", markersize=6, label=label)
                label = "_nolegend_"


def plot_branches(axes: Axes, job: OrbitsJob, columns: Columns) -> None:
    """Draw the speeds of departure along branches, thick where they attract, with special points and lost ends."""
    assert job.continuation is not None
    parameter = job.continuation.parameter
    for number, points in enumerate(slices(columns["branch_size"])):
        values, speeds = columns[parameter][points], columns["branch_velocity"][points]
        attracts = columns["branch_attracts"][points, None] == 1
        name, colour = columns["name"][columns["branch_orbit"][number]], f"C{number % 10}"
        axes.plot(values, speeds, color=colour, linewidth=0.6)
        axes.plot(values, np.where(attracts, speeds, np.nan), color=colour, linewidth=2.0)
        axes.plot([], [], color=colour, label=f"branch of {name}")
    _mark_lost_ends(axes, job, columns)
    for code, (kind, marker) in enumerate(_MARKERS.items(), 1):
        there = columns["special_kind"] == code
        speeds = columns["special_velocity"][there]
        if speeds.size:
            at = np.repeat(columns["special_value"][there], speeds.shape[1])
            axes.plot(at, speeds.ravel(), marker, color="black", markersize=4, fillstyle="none", label=kind.value)
    axes.set_xlabel(in_words(parameter))
    axes.set_ylabel("velocity v of departure")


def plot_curves(axes: Axes, job: OrbitsJob, columns: Columns) -> None:
    """Draw curves of special points in the plane of their two parameters."""
    assert job.continuation is not None and job.curves is not None
    for special, points in zip(columns["curve_special"].tolist(), slices(columns["curve_size"]), strict=True):
        kind = tuple(_MARKERS)[int(columns["special_kind"][special]) - 1]
        value = columns["special_value"][special]
        axes.plot(columns["curve_first"][points], columns["curve_second"][points], label=f"{kind.value} at {value:.5g}")
    for set_label, parameter in (
        (axes.set_xlabel, job.continuation.parameter),
        (axes.set_ylabel, job.curves.parameter),
    ):
        set_label(in_words(parameter))


def draw_orbits(job: OrbitsJob, columns: Columns, figure: Figure) -> None:
    """Draw orbits, or branches if there are any, with curves below them."""
    if job.continuation is None:
        drawn = [(figure.subplots(), plot_orbits)]
    elif job.curves is None:
        drawn = [(figure.subplots(), plot_branches)]
    else:
        figure.set_size_inches(10.0, 10.0)
        drawn = list(zip(figure.subplots(2), (plot_branches, plot_curves), strict=True))
    without = () if job.continuation is None else (job.continuation.parameter,)
    drawn[0][0].set_title(oscillator_text(job.oscillator, without))
    for axes, plot in drawn:
        plot(axes, job, columns)
        if axes.get_legend_handles_labels()[1]:
            axes.legend(
                loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, borderaxespad=0.0, fontsize="small"
            )
