"""The figures that can be recomputed: those of the paper in its order, then those of machines."""

from rattle import InvalidJob
from rattle_paper.figure import PaperFigure
from rattle_paper.figures.assembly import ASSEMBLY
from rattle_paper.figures.crises import CRISES
from rattle_paper.figures.fig1 import FIG1
from rattle_paper.figures.fig2_fig3 import FIG2, FIG3
from rattle_paper.figures.fig4 import FIG4
from rattle_paper.figures.fig5 import FIG5
from rattle_paper.figures.fig6 import FIG6
from rattle_paper.figures.fig7 import FIG7
from rattle_paper.figures.fig8_fig9 import FIG8, FIG9
from rattle_paper.figures.fig10 import FIG10
from rattle_paper.figures.fig11 import FIG11
from rattle_paper.figures.fig12_fig13 import FIG12, FIG13
from rattle_paper.figures.fig14 import FIG14
from rattle_paper.figures.fig15 import FIG15
from rattle_paper.figures.fig16 import FIG16
from rattle_paper.figures.fig17 import FIG17
from rattle_paper.figures.machine import MACHINE, MACHINE_SOFT
from rattle_paper.figures.machine_sweep import MACHINE_SWEEP
from rattle_paper.figures.proven import PROVEN
from rattle_paper.figures.sequel import SEQUEL

_IN_ORDER = (
    FIG1, FIG2, FIG3, FIG4, FIG5, FIG6, FIG7, FIG8, FIG9, FIG10, FIG11, FIG12, FIG13, FIG14, FIG15, FIG16, FIG17,
)  # fmt: skip

PAPER_FIGURES: dict[str, PaperFigure] = {figure.name: figure for figure in _IN_ORDER}
ALL_FIGURES = PAPER_FIGURES | {
    figure.name: figure for figure in (MACHINE, MACHINE_SOFT, MACHINE_SWEEP, ASSEMBLY, PROVEN, SEQUEL, CRISES)
}
"""Figures of the paper, of machines at dampings that it could not reach, of two gears, of proofs, of its sequel and of
crises."""


def figure_named(name: str) -> PaperFigure:
    """Figure with a given name.

    Raises
    ------
    InvalidJob
        If there is none. The message lists the figures that exist.
    """
    if name not in ALL_FIGURES:
        raise InvalidJob(f"there is no figure {name!r} to recompute; choose one of {', '.join(ALL_FIGURES)}")
    return ALL_FIGURES[name]
