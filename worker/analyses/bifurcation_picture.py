"""Picture of a bifurcation diagram: speeds of the last departures over the parameter, as in Figs. 10(a) and 11."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from worker.jobs.bifurcation_job import BifurcationJob, Direction
from worker.pictures.symbols import in_words, oscillator_text
from worker.stores.layout import MISSING, Columns

_COLOURS = ("black", "tab:red", "tab:blue", "tab:green", "tab:purple", "tab:orange")


def plot_diagram(axes: Axes, parameter: str, columns: Columns) -> None:
    """Draw a diagram on axes, with one colour per seed, paler on the way down than on the way up."""
    values, way = columns[parameter], columns["way"]
    for seed in range(columns["seed_time"].size):
        colour, name = _COLOURS[seed % len(_COLOURS)], str(columns["seed_name"][seed])
        for direction, way_name, alpha in ((1, "up", 1.0), (-1, "down", 0.45)):
            speeds = columns["velocity"][way == direction, seed]
            if np.isfinite(speeds).any():
                at = np.repeat(values[way == direction], speeds.shape[1])
                label = f"from {name} at v = {columns['seed_velocity'][seed]:.4g}, {way_name}"
                axes.plot(at, speeds.ravel(), ".", color=colour, alpha=alpha, markersize=1.2, label=label)
    axes.set_xlabel(in_words(parameter))
    axes.set_ylabel("velocity v of departure")
    axes.set_xlim(values.min(), values.max() if values.max() > values.min() else values.min() + 1e-6)


def draw_diagram(job: BifurcationJob, columns: Columns, figure: Figure) -> None:
    """Draw a diagram with title and legend."""
    axes = figure.subplots()
    plot_diagram(axes, job.vary.parameter, columns)
    title = oscillator_text(job.oscillator, without=(job.vary.parameter,))
    if (columns["outcome"] == MISSING).any() or not columns["seed_time"].size:
        title += "; incomplete"
    ways = {Direction.UP: "upwards", Direction.DOWN: "downwards", Direction.BOTH: "upwards, then downwards"}
    axes.set_title(f"{title}; {ways[job.direction]}")
    if axes.lines:
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, markerscale=6, borderaxespad=0.0)
