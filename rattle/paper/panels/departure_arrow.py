"""An arrow from a panel of a time history to its departure in a panel of basins."""

from matplotlib.axes import Axes
from matplotlib.patches import ConnectionPatch


def point_from(history: Axes, basin: Axes, t: float, v: float) -> None:
    """Draw an arrow from the left of a history panel to a departure in a panel of basins."""
    # Orange is visible on white paper and on all colours of basins except orange.
    arrow = ConnectionPatch(
        xyA=(-0.16, 0.5), coordsA=history.transAxes, xyB=(t, v), coordsB=basin.transData,
        arrowstyle="-|>", mutation_scale=13, color="tab:orange", linewidth=1.5, shrinkB=5.0, clip_on=False,
    )  # fmt: skip
    history.figure.add_artist(arrow)
