"""Fig. 16: an enlarged section of the basins, with the grazing curve, its pre-images and both stable manifolds."""

from matplotlib.figure import Figure

from rattle import BasinJob
from rattle.pictures import preimage_lines
from rattle_kernels import CellGrid
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.figures.fig15 import ARCLENGTH
from rattle_paper.numbers.solutions import oscillator_summary
from rattle_paper.panels.anatomy import (
    BASIN,
    manifold_overlays,
    manifolds,
    preimages,
    saddle_overlays,
    share_of_boundaries,
)
from rattle_paper.panels.basin_panel import draw_panel
from rattle_paper.papers_oscillator import papers_basin

# The paper does not state its section. This one contains both saddles, all three basins and both kinds of curves.
_TIME, _VELOCITY = (0.55, 1.0), (3.0, 4.8)
_HIGHEST = 7.0


def _basins(grid: CellGrid) -> dict[str, BasinJob]:
    return {BASIN: papers_basin(CellGrid(*_TIME, grid.time_cells, *_VELOCITY, grid.velocity_cells))}


def _make(results: Results, report: Report) -> Sheet:
    basin = results[BASIN]
    oscillator = basin.rattle.oscillator
    grown, orders = manifolds(oscillator, ARCLENGTH, _HIGHEST), preimages(oscillator, _HIGHEST)
    drawing = Figure(figsize=(8.0, 6.4), dpi=100, layout="constrained")
    axes = drawing.subplots()
    draw_panel(axes, basin, preimage_lines(orders[1:]))
    for line in manifold_overlays(grown):
        line.draw(axes, _TIME[0])
    axes.legend(loc="lower left", framealpha=0.6, fontsize="small")
    for marks in saddle_overlays(grown):
        marks.draw(axes, _TIME[0])
    shares = {f"manifold of {label}": share_of_boundaries(basin, each.pieces) for label, each in grown.items()}
    shares["both manifolds"] = share_of_boundaries(basin, [piece for each in grown.values() for piece in each.pieces])
    curves = [piece for pieces in orders for piece in pieces]
    shares["grazing curve and pre-images 1, 2"] = share_of_boundaries(basin, curves)
    window = {"time": list(_TIME), "velocity": list(_VELOCITY), "cells": list(basin.rattle.shown.solution.shape[::-1])}
    numbers = {"oscillator": oscillator_summary(oscillator), "window": window, "shares_of_boundaries": shares}
    return Sheet(drawing, numbers)


FIG16 = PaperFigure("fig16", "a section enlarged: grazing curve, pre-images and stable manifolds", _make, _basins)
