"""A panel of basins as the paper draws them: coloured by solution, with grazing curve, attractors and transients."""

import math
from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from rattle.paper.numbers.transients import on_transient
from rattle.paper.panels.basin_view import BasinView
from rattle_kernels import Attractor, AttractorKind, Oscillator
from worker.pictures import colours
from worker.pictures.overlay import Overlay, attractor_marks, grazing_line
from worker.pictures.panel_picture import frame

_MOST_DOTS = 4096
_NO_POINTS = np.empty(0)
# Stands for the cells that are on a transient after k applications.
_WANDERING = Attractor(AttractorKind.CHAOTIC, 0, 0, 0, np.nan, np.nan, _NO_POINTS, _NO_POINTS)


def landings_on_transient(view: BasinView) -> tuple[np.ndarray, np.ndarray]:
    """Phases and speeds of the landing points of ``P^k`` that are not yet on the orbit that they end in."""
    wandering = on_transient(view)
    return view.landing_time[wandering], view.landing_velocity[wandering]


def attractor_overlays(view: BasinView) -> tuple[Overlay, ...]:
    """Periodic attractors as white crosses; chaotic ones and landing points on transients as black dots."""
    t, v = landings_on_transient(view)
    dots = slice(None, None, max(1, t.size // _MOST_DOTS))
    return attractor_marks((_WANDERING._replace(time=t[dots], velocity=v[dots]), *view.attractors))


def draw_panel(axes: Axes, view: BasinView, overlays: Iterable[Overlay]) -> None:
    """Draw the basins of one oscillator.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    view : BasinView
        Cells on a chaotic transient after k applications are speckled dark red, as in the paper. Cells that have
        settled have the colour of their solution.
    overlays : iterable of Overlay
        Drawn between the cells and the grazing curve.
    """
    grid = view.job.grid
    solution = np.where(on_transient(view), len(view.attractors), view.solution)
    image = colours.paint_cells(solution, view.group, (*view.attractors, _WANDERING))
    extent = grid.time_start, grid.time_stop, grid.velocity_start, grid.velocity_stop
    axes.imshow(np.round(image, 2), origin="lower", extent=extent, aspect="auto", interpolation="nearest")
    for overlay in (*overlays, grazing_line(view.oscillator)):
        overlay.draw(axes, grid.time_start)
    frame(axes, extent)


def legend_of(view: BasinView) -> list[Patch]:
    """Legend entries: the share of each solution, and of a periodic one also the share not settled after k."""
    palette, wandering = colours.colours_of(view.attractors), on_transient(view)
    entries = []
    there = [index for index, share in enumerate(view.shares) if not math.isnan(share)]
    for index in sorted(there, key=lambda i: (i > 0, -view.shares[i])):
        name, share = view.attractors[index].name, view.shares[index]
        entries.append(_entry(palette[index], f"{name}  {100 * share:.2f} %"))
        late = float(np.mean(wandering & (view.solution == index)))
        if late > 0.0:
            entries.append(_entry(colours.CHAOTIC, f"   of it not settled at k  {100 * late:.2f} %"))
    return entries


def _entry(colour: colours.Colour, label: str) -> Patch:
    return Patch(facecolor=colour, edgecolor="black", label=label)


def model_of(oscillator: Oscillator) -> str:
    """Name of the model, with its stiffness."""
    if math.isinf(oscillator.stiffness):
        return "impacting model"
    mantissa, exponent = f"{oscillator.stiffness:e}".split("e")
    factor = "" if float(mantissa) == 1.0 else f"{float(mantissa):g}·"
    return f"piecewise linear model, κ = {factor}$10^{int(exponent)}$"
