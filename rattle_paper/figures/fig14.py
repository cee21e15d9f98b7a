"""Fig. 14: the grazing curve and its first and second pre-images on the basins at damping 0.6."""

from matplotlib.figure import Figure

from rattle.pictures import preimage_lines
from rattle_kernels import arclength
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.numbers.solutions import oscillator_summary
from rattle_paper.panels.anatomy import BASIN, preimages, share_of_boundaries, the_basin
from rattle_paper.panels.basin_panel import draw_panel


def _make(results: Results, report: Report) -> Sheet:
    basin = results[BASIN]
    oscillator = basin.rattle.oscillator
    orders = preimages(oscillator, basin.rattle.job.grid.velocity_stop)
    drawing = Figure(figsize=(8.0, 6.4), dpi=100, layout="constrained")
    axes = drawing.subplots()
    draw_panel(axes, basin, preimage_lines(orders[1:]))
    axes.legend(loc="lower left", framealpha=0.6, fontsize="small")
    scale = float(max(piece.v.max() for piece in orders[0]))
    summaries = [
        {
            "order": order,
            "arcs": len(pieces),
            "arclength": arclength(pieces, scale),
            "share_of_boundaries": share_of_boundaries(basin, pieces),
        }
        for order, pieces in enumerate(orders)
    ]
    together = share_of_boundaries(basin, [piece for pieces in orders for piece in pieces])
    numbers = {"oscillator": oscillator_summary(oscillator), "orders": summaries, "share_of_boundaries": together}
    return Sheet(drawing, numbers)


FIG14 = PaperFigure("fig14", "grazing curve and first and second pre-image on the basins", _make, the_basin)
