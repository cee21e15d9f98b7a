"""Pictures of one time history: Phi(t) between the backlash boundaries, as in the paper's Figs. 1 and 7."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle_kernels import Direction, Oscillator, TimeHistory
from worker.pictures.figure_file import new_figure
from worker.pictures.symbols import oscillator_text

# Free space above and below in a panel, as a fraction of the span drawn.
_MARGIN = 0.15
# Most contacts marked. More would hide the curve.
_MOST_MARKS = 400
# Most points of the curve: more than a picture has columns, and fewer than Agg's rasteriser overflows at.
_MOST_POINTS = 40_000
_MARKS = {
    Direction.IMPACT: ("o", "tab:red", "impact"),
    Direction.IN: ("v", "tab:red", "into contact"),
    Direction.OUT: ("^", "tab:green", "into freeplay"),
}


def draw_boundaries(axes: Axes, oscillator: Oscillator, walls: tuple[int, ...] = (1, -1)) -> None:
    """Draw +beta, -beta or both as dotted lines with their names.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Of displacement over time.
    oscillator : Oscillator
    walls : tuple of int
        1 for +beta, -1 for -beta.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> axes = Figure().subplots()
    >>> draw_boundaries(axes, Oscillator())
    >>> [text.get_text() for text in axes.texts]
    ['+β', '−β']
    """
    for wall in walls:
        name = "+β" if wall > 0 else "−β"
        axes.axhline(wall * oscillator.half_backlash, color="black", linestyle=":", linewidth=1.0)
        axes.annotate(
            name, (1.0, wall * oscillator.half_backlash), xycoords=("axes fraction", "data"), xytext=(4, 0),
            textcoords="offset points", va="center",
        )  # fmt: skip


def _thinned(history: TimeHistory) -> tuple[np.ndarray, np.ndarray]:
    """Times and displacements to draw: of very many, the extremes of each stretch."""
    time, displacement = history.time, history.displacement
    if time.size <= _MOST_POINTS:
        return time, displacement
    stretch = -(-2 * time.size // _MOST_POINTS)
    rows = np.pad(displacement, (0, -time.size % stretch), mode="edge").reshape(-1, stretch)
    first = np.arange(rows.shape[0]) * stretch
    extremes = np.concatenate([first + rows.argmin(axis=1), first + rows.argmax(axis=1), [0, time.size - 1]])
    kept = np.unique(np.minimum(extremes, time.size - 1))
    return time[kept], displacement[kept]


def _shade_contacts(axes: Axes, oscillator: Oscillator, time: np.ndarray, displacement: np.ndarray) -> None:
    inside = np.clip(displacement, -oscillator.half_backlash, oscillator.half_backlash)
    axes.fill_between(time, inside, displacement, color="tab:blue", alpha=0.25, linewidth=0.0)


def _mark_contacts(axes: Axes, oscillator: Oscillator, history: TimeHistory) -> None:
    contacts = history.contacts
    if contacts.time.size > _MOST_MARKS:
        return
    for direction, (marker, colour, label) in _MARKS.items():
        here = contacts.direction == direction
        if here.any():
            level = contacts.wall[here] * oscillator.half_backlash
            axes.plot(contacts.time[here], level, marker, color=colour, markersize=3, linestyle="none", label=label)
    if contacts.time.size:
        axes.legend(loc="upper left", bbox_to_anchor=(1.04, 1.0), frameon=False, borderaxespad=0.0)


def _title(oscillator: Oscillator, history: TimeHistory) -> str:
    title = oscillator_text(oscillator)
    return f"{title}\ntruncated at {history.contacts.time.size} contacts" if history.truncated else title


def history_figure(oscillator: Oscillator, history: TimeHistory) -> Figure:
    """Draw a time history.

    Parameters
    ----------
    oscillator : Oscillator
        The oscillator that made the history.
    history : TimeHistory

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = new_figure(11.0, 4.5)
    draw_history(figure, oscillator, history)
    return figure


def draw_history(figure: Figure, oscillator: Oscillator, history: TimeHistory) -> None:
    """Draw a time history on an empty figure."""
    axes = figure.add_subplot()
    draw_boundaries(axes, oscillator)
    time, displacement = _thinned(history)
    _shade_contacts(axes, oscillator, time, displacement)
    axes.plot(time, displacement, color="tab:blue", linewidth=1.0)
    _mark_contacts(axes, oscillator, history)
    if history.time[-1] > history.time[0]:
        axes.set_xlim(history.time[0], history.time[-1])
    axes.set_xlabel("time t (forcing periods)")
    axes.set_ylabel("displacement Φ")
    axes.set_title(_title(oscillator, history))


def draw_history_panel(axes: Axes, oscillator: Oscillator, history: TimeHistory, label: str) -> None:
    """Draw a time history from its beginning, with the label above it.

    A motion that stays in the upper half of the backlash is enlarged, and the label says so.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    oscillator : Oscillator
        The oscillator that made the history.
    history : TimeHistory
        Of `rattle_kernels.time_history`.
    label : str

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from rattle_kernels import Oscillator, time_history
    >>> axes = Figure().subplots()
    >>> history = time_history(Oscillator(), 0.25, 0.6, -4.0, periods=5.0)
    >>> draw_history_panel(axes, Oscillator(), history, "from +beta at 4.0")
    >>> axes.get_xlim()
    (np.float64(0.0), np.float64(5.0))
    """
    beta, phi = oscillator.half_backlash, history.displacement
    enlarged = phi.min() > 0.0
    draw_boundaries(axes, oscillator, walls=(1,) if enlarged else (1, -1))
    axes.plot(history.time - history.time[0], phi, color="tab:blue", linewidth=1.0)
    axes.set_xlim(0.0, max(history.time[-1] - history.time[0], 1e-9))
    lowest, highest = min(phi.min(), beta if enlarged else -beta), max(phi.max(), beta)
    margin = _MARGIN * (highest - lowest)
    axes.set_ylim(lowest - margin, highest + margin)
    axes.ticklabel_format(axis="y", scilimits=(-3, 4), useOffset=False)
    axes.set_ylabel("Φ(t)")
    axes.set_title(f"{label} (enlarged)" if enlarged else label, fontsize="medium", loc="left", pad=3)
