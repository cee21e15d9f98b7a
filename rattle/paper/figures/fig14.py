"""Fig. 14: the grazing curve and its first and second pre-images on the basins at damping 0.6."""

from collections.abc import Mapping

from matplotlib.figure import Figure

from rattle.paper.figure import PaperFigure, Report, Sheet
from rattle.paper.numbers.solutions import oscillator_summary
from rattle.paper.panels.anatomy import BASIN, preimages, share_of_boundaries, the_basin
from rattle.paper.panels.basin_panel import draw_panel
from rattle.paper.panels.basin_view import view_basin
from rattle_kernels import arclength
from worker.pictures.overlay import preimage_lines


def _make(stores: Mapping[str, str], report: Report) -> Sheet:
    view = view_basin(stores[BASIN])
    orders = preimages(view.oscillator, view.job.grid.velocity_stop)
    drawing = Figure(figsize=(8.0, 6.4), dpi=100, layout="constrained")
    axes = drawing.subplots()
    draw_panel(axes, view, preimage_lines(orders[1:]))
    axes.legend(loc="lower left", framealpha=0.6, fontsize="small")
    scale = float(max(piece.v.max() for piece in orders[0]))
    summaries = [
        {
            "order": order,
            "arcs": len(pieces),
            "arclength": arclength(pieces, scale),
            "share_of_boundaries": share_of_boundaries(view, pieces),
        }
        for order, pieces in enumerate(orders)
    ]
    together = share_of_boundaries(view, [piece for pieces in orders for piece in pieces])
    numbers = {"oscillator": oscillator_summary(view.oscillator), "orders": summaries, "share_of_boundaries": together}
    return Sheet(drawing, numbers)


FIG14 = PaperFigure("fig14", "grazing curve and first and second pre-image on the basins", _make, the_basin)
