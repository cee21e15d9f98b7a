"""A small panel of one time history, Phi(t) between the backlash boundaries, and an arrow to its departure."""

from matplotlib.axes import Axes
from matplotlib.patches import ConnectionPatch

from rattle_kernels import Oscillator, TimeHistory
from worker.pictures.history_picture import draw_boundaries

# Free space above and below, as a fraction of the span drawn.
_MARGIN = 0.15


def draw_history_panel(axes: Axes, oscillator: Oscillator, history: TimeHistory, label: str) -> None:
    """Draw a time history from its beginning, with the label above it.

    A motion that stays in the upper half of the backlash is enlarged, and the label says so.
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


def point_from(history: Axes, basin: Axes, t: float, v: float) -> None:
    """Draw an arrow from the left of a history panel to a departure in a panel of basins."""
    # Orange is visible on white paper and on all colours of basins except orange.
    arrow = ConnectionPatch(
        xyA=(-0.16, 0.5), coordsA=history.transAxes, xyB=(t, v), coordsB=basin.transData,
        arrowstyle="-|>", mutation_scale=13, color="tab:orange", linewidth=1.5, shrinkB=5.0, clip_on=False,
    )  # fmt: skip
    history.figure.add_artist(arrow)
