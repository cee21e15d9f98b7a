"""A panel of basins as the paper draws them: coloured by solution, with grazing curve, attractors and transients."""

import math
from collections.abc import Iterable

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from rattle.pictures import Overlay, Palette, attractor_marks, colours_of, frame, grazing_line, paint_cells
from rattle_kernels import Attractor, AttractorKind, Oscillator
from rattle_paper.numbers.transients import on_transient

_MOST_DOTS = 4096
_NO_POINTS = np.empty(0)
# Stands for the cells that are on a transient after k applications.
_WANDERING = Attractor(AttractorKind.CHAOTIC, 0, 0, 0, np.nan, np.nan, _NO_POINTS, _NO_POINTS)
(COLOUR_OF_TRANSIENTS,) = colours_of((_WANDERING,), Palette.PAPER)


def landings_on_transient(basin: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Phases and speeds of the landing points of ``P^k`` that are not yet on the orbit that they end in."""
    wandering, shown = on_transient(basin), basin.rattle.shown
    return shown.landing_time.values[wandering], shown.landing_velocity.values[wandering]


def attractor_overlays(basin: xr.Dataset) -> tuple[Overlay, ...]:
    """Periodic attractors as white crosses; chaotic ones and landing points on transients as black dots."""
    t, v = landings_on_transient(basin)
    dots = slice(None, None, max(1, t.size // _MOST_DOTS))
    return attractor_marks((_WANDERING._replace(time=t[dots], velocity=v[dots]), *basin.rattle.catalogue()))


def draw_panel(axes: Axes, basin: xr.Dataset, overlays: Iterable[Overlay]) -> None:
    """Draw the basins of one oscillator.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    basin : xarray.Dataset
        Cells on a chaotic transient after k applications are speckled dark red, as in the paper. Cells that have
        settled have the colour of their solution.
    overlays : iterable of Overlay
        Drawn between the cells and the grazing curve.
    """
    grid, attractors, shown = basin.rattle.job.grid, basin.rattle.catalogue(), basin.rattle.shown
    solution = np.where(on_transient(basin), len(attractors), shown.solution)
    image = paint_cells(solution, shown.group, (*attractors, _WANDERING), Palette.PAPER)
    extent = grid.time_start, grid.time_stop, grid.velocity_start, grid.velocity_stop
    axes.imshow(np.round(image, 2), origin="lower", extent=extent, aspect="auto", interpolation="nearest")
    for overlay in (*overlays, grazing_line(basin.rattle.oscillator)):
        overlay.draw(axes, grid.time_start)
    frame(axes, extent)


def legend_of(basin: xr.Dataset) -> list[Patch]:
    """Legend entries: the share of each solution, and of a periodic one also the share not settled after k."""
    names, shares = basin.name.values, basin.share.values
    palette = colours_of(basin.rattle.catalogue(), Palette.PAPER)
    wandering, solution = on_transient(basin), basin.rattle.shown.solution.values
    entries = []
    for index in sorted(np.flatnonzero(np.isfinite(shares)).tolist(), key=lambda i: (i > 0, -shares[i])):
        entries.append(_entry(palette[index], f"{names[index]}  {100 * shares[index]:.2f} %"))
        late = float(np.mean(wandering & (solution == index)))
        if late > 0.0:
            entries.append(_entry(COLOUR_OF_TRANSIENTS, f"   of it not settled at k  {100 * late:.2f} %"))
    return entries


def _entry(colour: tuple[float, float, float], label: str) -> Patch:
    return Patch(facecolor=colour, edgecolor="black", label=label)


def model_of(oscillator: Oscillator) -> str:
    """Name of the model, with its stiffness."""
    if math.isinf(oscillator.stiffness):
        return "impacting model"
    mantissa, exponent = f"{oscillator.stiffness:e}".split("e")
    factor = "" if float(mantissa) == 1.0 else f"{float(mantissa):g}·"
    return f"piecewise linear model, κ = {factor}$10^{int(exponent)}$"
