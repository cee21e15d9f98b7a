"""Picture of a bifurcation diagram: speeds of the last departures over the parameter, as in Figs. 10(a) and 11."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.path import Path

from worker.jobs.bifurcation_job import BifurcationJob, Direction
from worker.pictures.colours import paints_of_names
from worker.pictures.symbols import in_words, oscillator_text
from worker.stores.layout import MISSING, Columns
from worker.views.motion_names import MOST_NAMED, NO_PERIOD, motion_names

_LISTED = 12
# Dots, and where colours come again, strokes up, strokes down and dashes: as in the page's diagrams.
_MARKS = (".", Path([(-1, -1), (1, 1)]), Path([(-1, 1), (1, -1)]), Path([(-1, 0), (1, 0)]))
_SIZES = (1.2, 2.0, 2.0, 2.0)


def names_of(job: BifurcationJob, columns: Columns) -> np.ndarray:
    """Name of the motion at each visit of each seed; of very many motions only how many impacts they have.

    Parameters
    ----------
    job : BifurcationJob
    columns : mapping of str to ndarray
        Of its store.

    Returns
    -------
    ndarray of str, shape (visits, seeds)
        Empty where nothing is computed.
    """
    shape = columns["outcome"].shape
    if columns["outcome"].size <= MOST_NAMED:
        return np.array(motion_names(job, columns), dtype=object).reshape(shape)
    periods = columns["impact_period"].ravel().tolist()
    named = [f"repeats after {n} impact{'s' if n > 1 else ''}" if n > 0 else NO_PERIOD for n in periods]
    return np.array(named, dtype=object).reshape(shape)


def _in_key(job: BifurcationJob, name: str) -> str:
    return f"no period within {job.kept // 2} impacts: chaos, or longer" if name == NO_PERIOD else name


def plot_diagram(axes: Axes, job: BifurcationJob, columns: Columns) -> None:
    """Draw a diagram on axes, each departure in the colour of the motion that it belongs to."""
    parameter = job.vary.parameter
    values, speeds = columns[parameter], columns["velocity"]
    at = np.broadcast_to(values[:, None, None], speeds.shape)
    names = np.broadcast_to(names_of(job, columns)[..., None], speeds.shape)[np.isfinite(speeds)]
    at, speeds = at[np.isfinite(speeds)], speeds[np.isfinite(speeds)]
    there, counts = np.unique(names[names != ""].astype(str), return_counts=True)
    paints = paints_of_names(there.tolist())
    # What there is less of lies on top.
    for place, name in enumerate(there[np.argsort(-counts, kind="stable")].tolist()):
        colour, texture = paints[name]
        listed = _in_key(job, name) if place < _LISTED else None
        axes.plot(
            at[names == name], speeds[names == name], linestyle="none", marker=_MARKS[texture], color=colour,
            markersize=_SIZES[texture], label=listed,
        )  # fmt: skip
    if len(there) > _LISTED:
        axes.plot([], [], linestyle="none", label=f"and {len(there) - _LISTED} more")
    axes.set_xlabel(in_words(parameter))
    axes.set_ylabel("velocity v of departure")
    axes.set_xlim(values.min(), values.max() if values.max() > values.min() else values.min() + 1e-6)


def draw_diagram(job: BifurcationJob, columns: Columns, figure: Figure) -> None:
    """Draw a diagram with title and legend."""
    axes = figure.subplots()
    plot_diagram(axes, job, columns)
    title = oscillator_text(job.oscillator, without=(job.vary.parameter,))
    if (columns["outcome"] == MISSING).any() or not columns["seed_time"].size:
        title += "; incomplete"
    ways = {Direction.UP: "upwards", Direction.DOWN: "downwards", Direction.BOTH: "upwards, then downwards"}
    axes.set_title(f"{title}; {ways[job.direction]}")
    if axes.lines:
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, markerscale=6, borderaxespad=0.0)
