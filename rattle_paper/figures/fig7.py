"""Fig. 7: basins at kappa = 1e6 above those of the impacting limit, with attractors and their time histories.

At kappa = 1e6 the paper shows chaos where the catalogue finds P(8,8,5): the chaos seen after 1499 impacts is transient.
The panel shows both. Cells still on the transient are speckled dark red, and their landing points are black. Cells that
have settled have the colour of the orbit. Both have a time history.
"""

from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import ConnectionPatch

from rattle import BasinJob
from rattle.pictures import draw_history_panel
from rattle_kernels import Attractor, CellGrid, Oscillator, TimeHistory, time_history
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.numbers.solutions import basin_summary, differences_summary
from rattle_paper.numbers.transients import measure_transient, on_transient
from rattle_paper.panels.basin_panel import attractor_overlays, draw_panel, landings_on_transient, legend_of, model_of
from rattle_paper.papers_oscillator import papers_basin

_STIFF, _LIMIT = "piecewise linear", "impacting"
_STIFFNESS = 1e6
_PERIODS = 10.0
# A departure that ends in permanent contact.
_QUIET_DEPARTURE = (0.2, 1.0)


def _point_from(history: Axes, basin: Axes, t: float, v: float) -> None:
    """Draw an arrow from the left of a history panel to a departure in a panel of basins."""
    # Orange is visible on white paper and on all colours of basins except orange.
    arrow = ConnectionPatch(
        xyA=(-0.16, 0.5), coordsA=history.transAxes, xyB=(t, v), coordsB=basin.transData,
        arrowstyle="-|>", mutation_scale=13, color="tab:orange", linewidth=1.5, shrinkB=5.0, clip_on=False,
    )  # fmt: skip
    history.figure.add_artist(arrow)


class _Example(NamedTuple):
    """A motion to follow: its label, and a departure on it."""

    label: str
    t: float
    v: float


def _basins(grid: CellGrid) -> dict[str, BasinJob]:
    return {_STIFF: papers_basin(grid, _STIFFNESS), _LIMIT: papers_basin(grid)}


def _examples(basin: xr.Dataset) -> list[_Example]:
    """A departure on each motion and on the transient, if any, the fastest first; last, one that becomes quiet."""
    examples = [_example_of(motion) for motion in basin.rattle.catalogue() if motion.time.size]
    t, v = landings_on_transient(basin)
    if t.size:
        settles = basin.name.values[_last_to_settle(basin)]
        label = f"chaotic at k = {basin.rattle.job.iterations}, in the end {settles}"
        examples.append(_Example(label, float(t[0]), float(v[0])))
    return [*sorted(examples, key=lambda example: -example.v), _Example("permanent contact", *_QUIET_DEPARTURE)]


def _example_of(motion: Attractor) -> _Example:
    fastest = int(np.argmax(motion.velocity))
    return _Example(motion.name, float(motion.time[fastest]), float(motion.velocity[fastest]))


def _last_to_settle(basin: xr.Dataset) -> int:
    """Index of the orbit with the most cells that have not settled on it after k applications."""
    return int(np.bincount(basin.rattle.shown.solution.values[on_transient(basin)]).argmax())


def _history(oscillator: Oscillator, example: _Example) -> TimeHistory:
    return time_history(oscillator, example.t, oscillator.half_backlash, -example.v, periods=_PERIODS)


def _draw_row(drawing: Any, basin: xr.Dataset) -> None:
    """Draw one model: its basins, and beside them time histories with arrows to their departures."""
    left, beside = drawing.subfigures(1, 2, width_ratios=(1.3, 1.0))
    axes, oscillator = left.subplots(), basin.rattle.oscillator
    draw_panel(axes, basin, attractor_overlays(basin))
    axes.set_title(f"{model_of(oscillator)}, k = {basin.rattle.job.iterations}", fontsize="medium")
    axes.legend(handles=legend_of(basin), loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=2, fontsize="small")
    examples = _examples(basin)
    panels: list[Axes] = list(beside.subplots(len(examples), 1, sharex=True, squeeze=False)[:, 0])
    for panel, example in zip(panels, examples, strict=True):
        draw_history_panel(panel, oscillator, _history(oscillator, example), example.label)
        _point_from(panel, axes, example.t, example.v)
    panels[-1].set_xlabel("time since the departure (forcing periods)")


def _transient_summary(basin: xr.Dataset) -> dict[str, Any]:
    wandering, shown = on_transient(basin), basin.rattle.shown
    if not wandering.any():
        return {}
    index = _last_to_settle(basin)
    orbit, ends_there = basin.rattle.catalogue()[index], wandering & (shown.solution.values == index)
    t, v = shown.landing_time.values[ends_there], shown.landing_velocity.values[ends_there]
    measured = measure_transient(basin.rattle.oscillator, orbit, t, v)
    return {
        "transient": {
            "settles_on": orbit.name,
            "left_after_legs": list(measured.left),
            "impacts_a_leg": measured.leg_impacts,
            "mean_life_impacts": measured.mean_life,
            "mean_life_error": measured.error,
            "lyapunov_exponent": measured.exponent,
        }
    }


def _make(results: Results, report: Report) -> Sheet:
    drawing = Figure(figsize=(12.0, 14.0), dpi=80, layout="constrained")
    rows: Any = drawing.subfigures(2, 1, height_ratios=(1.1, 1.0))
    panels: dict[str, Any] = {}
    for number, (name, basin) in enumerate(results.items()):
        report("histories and transients", number, len(results))
        _draw_row(rows[number], basin)
        panels[name] = basin_summary(basin) | _transient_summary(basin)
    differences = differences_summary(results[_STIFF], results[_LIMIT])
    return Sheet(drawing, {"panels": panels, "differs_from_impacting": differences})


FIG7 = PaperFigure("fig7", "basins at kappa = 1e6 and in the impacting limit, and time histories", _make, _basins)
