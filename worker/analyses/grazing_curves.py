"""Pre-images of the grazing curve as an analysis: stretches of the curve run in parallel, each through all orders."""

import json
from collections.abc import Collection, Mapping
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy import float64, int8, int64
from pydantic import BaseModel, Field

from rattle_kernels import CurveResolution, FirstCurve, Oscillator, Piece, arclength
from rattle_kernels.manifolds.grazing_preimages import STRETCHES, join_stretches, preimages_of_stretch
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.numerics.pausing import Pause
from worker.analyses import analysis
from worker.analyses.analysis import Analysis, AnalysisView, Parts, Plan, ready_of
from worker.analyses.curves import PIECES, THIN, finish_plane, piece_columns, pieces_of
from worker.jobs.grazing_curve_job import GrazingCurveJob
from worker.pictures.overlay import Lines
from worker.pictures.symbols import oscillator_text
from worker.progress import Stage
from worker.stores.layout import Columns, Variable
from worker.stores.table import Column, Table, slices

_SIZE = {"sample_dimension": "piece"}
_FIRST = {
    FirstCurve.LOWER: "grazing curve",
    FirstCurve.UPPER: "grazes of +beta",
    FirstCurve.REST: "edge of rest",
}
# Colours of what is laid over a basin, by order.
_OVER = ("white", "black", "yellow", "magenta", "lime")
ORDERS = Table("order", (
    Column("order_complete", int8, "1 where all of the pre-image of this order is there, else 0", None),
    Column("order_arclength", float64, "its length in the plane (t, v/velocity scale)", None),
    Column("order_size", int64, "pieces of an order, which follow those of the one before", None, _SIZE),
), prefix="order_")  # fmt: skip


class OrderView(BaseModel):
    """A pre-image of one order."""

    order: int
    complete: bool = Field(description="False where it is not there yet, or needs more points than were allowed")
    pieces: int
    vertices: int
    arclength: float


class GrazingCurveView(AnalysisView):
    """Summary of a grazing curve; its vertices are in the store."""

    kind: Literal["grazing_curve"]
    orders: list[OrderView]


def map_stretch(
    oscillator: Oscillator, order: int, stretch: int, velocity: tuple[float, float], resolution: CurveResolution,
    most_points: int, first: FirstCurve, *, pause: Pause,
) -> Columns:  # fmt: skip
    """A stretch of the grazing curve and its pre-images."""
    orders = preimages_of_stretch(oscillator, order, stretch, resolution, velocity, most_points, pause, first)
    columns = PIECES.join([piece_columns(pieces, velocity) for pieces in orders])
    return columns | {"order_size": np.array([len(pieces) for pieces in orders], np.int64)}


def _name(stretch: int) -> str:
    return f"stretch-{stretch}"


def plan(job: GrazingCurveJob, parts: Parts) -> Plan:
    """Map every stretch."""
    most = -(-job.most_points // STRETCHES)
    pieces = [
        analysis.Piece(
            _name(stretch),
            map_stretch,
            (job.oscillator, job.order, stretch, job.velocity.ends, job.resolution, most, job.first),
        )
        for stretch in range(STRETCHES)
    ]
    return ready_of(Stage.TRACING, pieces, parts)


def _pieces_of_order(parts: Parts, order: int) -> tuple[list[list[Piece]], bool]:
    """Pieces of an order, stretch by stretch, and whether the order is complete."""
    stretches: list[list[Piece]] = []
    whole = True
    for stretch in range(STRETCHES):
        part = parts[_name(stretch)] if _name(stretch) in parts else None
        if part is None or part["order_size"].size <= order:
            stretches.append([])
            whole = False
            continue
        stop = int(part["order_size"][: order + 1].sum())
        stretches.append(pieces_of(part)[stop - int(part["order_size"][order]) : stop])
    return stretches, whole


def assemble(job: GrazingCurveJob, parts: Parts) -> Columns:
    """Pieces of all orders, one order after another."""
    scale = largest_grazing_speed(job.oscillator)
    orders, complete = [], []
    for order in range(job.order + 1):
        stretches, whole = _pieces_of_order(parts, order)
        orders.append(join_stretches(stretches))
        complete.append(whole)
    return PIECES.join([piece_columns(pieces, job.velocity.ends) for pieces in orders]) | {
        "order_complete": np.array(complete, np.int8),
        "order_arclength": np.array([arclength(pieces, scale) for pieces in orders]),
        "order_size": np.array([len(pieces) for pieces in orders], np.int64),
    }


def layout(job: GrazingCurveJob) -> tuple[Variable, ...]:
    """Variables of the store: orders, pieces, vertices."""
    return (*ORDERS.variables, *PIECES.variables)


def orders_of(columns: Mapping[str, Any]) -> list[list[Piece]]:
    """Pieces of each order, the grazing curve first, from a store's columns or an xarray dataset."""
    pieces = pieces_of(columns)
    return [pieces[own] for own in slices(np.asarray(columns["order_size"]))]


def summarise(job: GrazingCurveJob, columns: Columns) -> dict[str, Any]:
    """Orders with their lengths. An incomplete order needs more points than allowed, or is not computed yet."""
    orders = [
        OrderView(
            order=order,
            complete=bool(row.complete),
            pieces=len(pieces),
            vertices=int(sum(piece.t.size for piece in pieces)),
            arclength=row.arclength,
        )
        for order, (row, pieces) in enumerate(zip(ORDERS.rows(columns), orders_of(columns), strict=True))
    ]
    return {"orders": orders}


def overlays_of(dataset: xr.Dataset, names: Collection[str] = ()) -> tuple[Lines, ...]:
    """The first curve and its pre-images, each in a colour of its own. They have no other names to choose by."""
    first = _FIRST[FirstCurve(json.loads(dataset.attrs["request"]).get("first", FirstCurve.LOWER))]
    return tuple(
        Lines(f"pre-image {order}" if order else first, _OVER[order % len(_OVER)], tuple(pieces))
        for order, pieces in enumerate(orders_of(dataset))
    )


def draw_grazing_curves(job: GrazingCurveJob, columns: Columns, figure: Figure) -> None:
    """Draw the grazing curve and its pre-images, with one colour per order."""
    axes = figure.subplots()
    for order, pieces in enumerate(orders_of(columns)):
        label = _FIRST[job.first] if order == 0 else f"pre-image of order {order}"
        missing = "" if columns["order_complete"][order] else ", incomplete"
        Lines(label + missing, f"C{order % 10}", tuple(pieces), THIN).draw(axes)
    finish_plane(axes, oscillator_text(job.oscillator), job.velocity.ends)


GRAZING_CURVE = Analysis(
    "Grazing curve of a rattling gear pair and its pre-images", GrazingCurveJob, plan, assemble, layout, summarise,
    GrazingCurveView, draw_grazing_curves,
)  # fmt: skip
