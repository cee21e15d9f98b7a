"""A small panel of one time history, Phi(t) between the backlash boundaries, and an arrow from it to its place."""

from matplotlib.axes import Axes
from matplotlib.patches import ConnectionPatch

from rattle_kernels import Oscillator, TimeHistory
from worker.history_picture import draw_boundaries

# Of the backlash, what is left free above and below the boundaries.
_MARGIN = 0.35


def draw_history_panel(axes: Axes, oscillator: Oscillator, history: TimeHistory, label: str) -> None:
    """Draw a time history from its beginning, with the label above it."""
    draw_boundaries(axes, oscillator)
    axes.plot(history.time - history.time[0], history.displacement, color="tab:blue", linewidth=1.0)
    axes.set_xlim(0.0, max(history.time[-1] - history.time[0], 1e-9))
    beta = oscillator.half_backlash
    highest, lowest = max(history.displacement.max(), beta), min(history.displacement.min(), -beta)
    axes.set_ylim(lowest - _MARGIN * beta, highest + _MARGIN * beta)
    axes.set_ylabel("Φ(t)")
    axes.set_title(label, fontsize="medium", loc="left", pad=3)


def point_from(history: Axes, basin: Axes, t: float, v: float) -> None:
    """Draw an arrow from the left of a history's panel to a departure in a panel of basins."""
    for colour, width in (("white", 3.4), ("black", 1.3)):  # black, to be seen on white; with a white rim, on dark
        arrow = ConnectionPatch(
            xyA=(-0.16, 0.5), coordsA=history.transAxes, xyB=(t, v), coordsB=basin.transData,
            arrowstyle="-|>", mutation_scale=12, color=colour, linewidth=width, shrinkB=5.0, clip_on=False,
        )  # fmt: skip
        history.figure.add_artist(arrow)
