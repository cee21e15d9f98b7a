"""Fig. 5: the cell map P_cell and the map P_corr o P^k (k = 4), on cells large enough to be seen.

The paper sketches both. Here they are computed for the impacting model, near its attracting P(1,1,0).
"""

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rattle_kernels import CellGrid, next_impacts
from rattle_paper.figure import PaperFigure, Report, Results, Sheet
from rattle_paper.numbers.solutions import oscillator_summary
from rattle_paper.papers_oscillator import papers_oscillator

_GRID = CellGrid(0.8, 1.0, 8, 3.4, 4.1, 7)
_STEPS = 4
_FIRST = (1, 5)  # row and column of the first cell

Point = tuple[float, float]


class _Step(NamedTuple):
    """A point, its image under P, and the centre of the image's cell if the image is moved there."""

    start: Point
    image: Point
    centre: Point | None


def _cell_of(point: Point) -> tuple[int, int]:
    """Row and column of the cell that contains a point of the window."""
    column = (point[0] - _GRID.time_start) / (_GRID.time_stop - _GRID.time_start) * _GRID.time_cells
    row = (point[1] - _GRID.velocity_start) / (_GRID.velocity_stop - _GRID.velocity_start) * _GRID.velocity_cells
    return int(np.floor(row)), int(np.floor(column))


def _centre_of(cell: tuple[int, int]) -> Point:
    return float(_GRID.time_centres()[cell[1]]), float(_GRID.velocity_centres()[cell[0]])


def _steps(corrected_each_time: bool) -> list[_Step]:
    here, steps = _centre_of(_FIRST), list[_Step]()
    for number in range(_STEPS):
        landed = next_impacts(papers_oscillator(), *here)
        image = float(landed.t), float(landed.v)
        put_back = corrected_each_time or number == _STEPS - 1
        steps.append(_Step(here, image, _centre_of(_cell_of(image)) if put_back else None))
        here = steps[-1].centre or image
    return steps


def _draw(axes: Axes, steps: list[_Step]) -> None:
    t = np.linspace(_GRID.time_start, _GRID.time_stop, _GRID.time_cells + 1)
    v = np.linspace(_GRID.velocity_start, _GRID.velocity_stop, _GRID.velocity_cells + 1)
    axes.vlines(t, v[0], v[-1], color="lightgray", linewidth=0.8)
    axes.hlines(v, t[0], t[-1], color="lightgray", linewidth=0.8)
    for step in steps:
        axes.annotate("", step.image, step.start, arrowprops={"arrowstyle": "-|>", "color": "tab:blue"})
        axes.plot(*step.image, ".", color="tab:blue")
        if step.centre is not None:
            axes.annotate("", step.centre, step.image, arrowprops={"arrowstyle": "->", "color": "tab:red"})
            axes.plot(*step.centre, "s", color="tab:red", markersize=5)
    axes.plot(*steps[0].start, "s", color="black", markersize=6)
    axes.set(xlim=(t[0], t[-1]), ylim=(v[0], v[-1]), xlabel="time t of departure (forcing periods)")


def _make(results: Results, report: Report) -> Sheet:
    drawing = Figure(figsize=(12.0, 5.2), dpi=90, layout="constrained")
    maps = {"P_cell": _steps(True), "P_corr o P^4": _steps(False)}
    titles = ("(a) P_cell, four times", "(b) P_corr ∘ P⁴")
    for axes, steps, title in zip(drawing.subplots(1, 2, sharey=True), maps.values(), titles, strict=True):
        _draw(axes, steps)
        axes.set_title(title)
    drawing.axes[0].set_ylabel("velocity v of departure")
    summaries = {
        name: {"images": [step.image for step in steps], "ends_in": list(_cell_of(steps[-1].image))}
        for name, steps in maps.items()
    }
    window = {"time": [_GRID.time_start, _GRID.time_stop], "velocity": [_GRID.velocity_start, _GRID.velocity_stop]}
    grid = window | {"cells": [_GRID.time_cells, _GRID.velocity_cells]}
    start = {"grid": grid, "starts_in": list(_FIRST), "starts_at": list(_centre_of(_FIRST))}
    return Sheet(drawing, {"oscillator": oscillator_summary(papers_oscillator())} | start | {"maps": summaries})


FIG5 = PaperFigure("fig5", "a cell's images under P_cell, and under P_corr o P^4", _make)
