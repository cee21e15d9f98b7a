"""A small panel of one time history: Phi(t) between the backlash boundaries, from its beginning on."""

from matplotlib.axes import Axes

from rattle_kernels import Oscillator, TimeHistory
from worker.pictures.history_picture import draw_boundaries

# Free space above and below, as a fraction of the span drawn.
_MARGIN = 0.15


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
