"""The figures that can be recomputed, in the paper's order, and those of the machine."""

from worker.errors import InvalidJob
from worker.paper.figure import PaperFigure
from worker.paper.figures.fig1 import FIG1
from worker.paper.figures.fig2_fig3 import FIG2, FIG3
from worker.paper.figures.fig4 import FIG4
from worker.paper.figures.fig5 import FIG5
from worker.paper.figures.fig6 import FIG6
from worker.paper.figures.fig7 import FIG7
from worker.paper.figures.fig8_fig9 import FIG8, FIG9
from worker.paper.figures.fig10 import FIG10
from worker.paper.figures.fig11 import FIG11
from worker.paper.figures.fig12_fig13 import FIG12, FIG13
from worker.paper.figures.fig14 import FIG14
from worker.paper.figures.fig15 import FIG15
from worker.paper.figures.fig16 import FIG16
from worker.paper.figures.fig17 import FIG17
from worker.paper.machine import MACHINE, MACHINE_SOFT
from worker.paper.machine_sweep import MACHINE_SWEEP

_IN_ORDER = (
    FIG1, FIG2, FIG3, FIG4, FIG5, FIG6, FIG7, FIG8, FIG9, FIG10, FIG11, FIG12, FIG13, FIG14, FIG15, FIG16, FIG17,
)  # fmt: skip

PAPER_FIGURES: dict[str, PaperFigure] = {figure.name: figure for figure in _IN_ORDER}
ALL_FIGURES = PAPER_FIGURES | {figure.name: figure for figure in (MACHINE, MACHINE_SOFT, MACHINE_SWEEP)}
"""Those of the paper, and those of the machine at dampings that it could not reach."""


def figure_named(name: str) -> PaperFigure:
    """Figure of that name.

    Raises
    ------
    InvalidJob
        Where there is none; it lists those that there are.
    """
    if name not in ALL_FIGURES:
        raise InvalidJob(f"there is no figure {name!r} to recompute; choose one of {', '.join(ALL_FIGURES)}")
    return ALL_FIGURES[name]
