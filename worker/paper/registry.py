"""The figures that can be recomputed, in the paper's order."""

from worker.errors import InvalidJob
from worker.paper.fig1 import FIG1
from worker.paper.fig4 import FIG4
from worker.paper.fig6 import FIG6
from worker.paper.fig7 import FIG7
from worker.paper.fig8 import FIG8
from worker.paper.fig9 import FIG9
from worker.paper.figure import PaperFigure

PAPER_FIGURES: dict[str, PaperFigure] = {figure.name: figure for figure in (FIG1, FIG4, FIG6, FIG7, FIG8, FIG9)}


def figure_named(name: str) -> PaperFigure:
    """Figure of that name.

    Raises
    ------
    InvalidJob
        Where there is none; it lists those that there are.
    """
    if name not in PAPER_FIGURES:
        raise InvalidJob(f"there is no figure {name!r} to recompute; choose one of {', '.join(PAPER_FIGURES)}")
    return PAPER_FIGURES[name]
