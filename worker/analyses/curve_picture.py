"""Pictures of curves in the (t, v) plane: manifolds of saddles, and pre-images of the grazing curve."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle_kernels import grazing_velocity
from worker.analyses.curve_table import pieces_of
from worker.jobs.grazing_curve_job import GrazingCurveJob
from worker.jobs.manifold_job import ManifoldJob
from worker.pictures.overlay import Lines
from worker.pictures.symbols import oscillator_text
from worker.stores.layout import Columns
from worker.stores.table import slices

_THIN = 0.8
_MANIFOLDS = {1: ("stable", "-"), 2: ("unstable", ":")}


def _finish(axes: Axes, title: str, velocity: tuple[float, float]) -> None:
    axes.set_title(title)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(velocity)
    axes.set_xlabel("time t of departure (forcing periods)")
    axes.set_ylabel("velocity v of departure")
    axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize="small")


def draw_manifolds(job: ManifoldJob, columns: Columns, figure: Figure) -> None:
    """Draw saddles and their manifolds, stable ones solid and unstable ones dotted, with one colour per saddle."""
    axes = figure.subplots()
    t = np.linspace(0.0, 1.0, 512)
    axes.plot(t, grazing_velocity(job.oscillator, t), color="gray", linewidth=1.0, label="grazing curve")
    pieces, branches = pieces_of(columns), slices(columns["branch_size"])
    for number, name in enumerate(columns["name"]):
        colour = f"C{number % 10}"
        for kind, (manifold, style) in _MANIFOLDS.items():
            own = np.flatnonzero((columns["branch_kind"] == kind) & (columns["branch_orbit"] == number))
            arcs = [piece for branch in own for piece in pieces[branches[branch]]]
            Lines(f"{manifold} manifold of {name}", colour, tuple(arcs), _THIN, style).draw(axes)
        marks = columns["orbit_time"][number], columns["orbit_velocity"][number]
        axes.plot(*marks, "+", color="black", markersize=9, label=f"saddle {name}")
    window = job.limits.lowest_velocity, job.limits.highest_velocity
    _finish(axes, oscillator_text(job.oscillator), window)


def draw_grazing_curves(job: GrazingCurveJob, columns: Columns, figure: Figure) -> None:
    """Draw the grazing curve and its pre-images, with one colour per order."""
    axes = figure.subplots()
    pieces = pieces_of(columns)
    for order, own in enumerate(slices(columns["order_size"])):
        label = "grazing curve" if order == 0 else f"pre-image of order {order}"
        missing = "" if columns["order_complete"][order] else ", incomplete"
        Lines(label + missing, f"C{order % 10}", tuple(pieces[own]), _THIN).draw(axes)
    _finish(axes, oscillator_text(job.oscillator), job.velocity.ends)
