"""The analyses there are, by the kind of their jobs, and their pictures."""

from pathlib import Path
from typing import IO

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from worker.analyses.analysis import Analysis
from worker.analyses.bifurcation import BIFURCATION
from worker.analyses.grazing_curves import GRAZING_CURVE
from worker.analyses.manifolds import MANIFOLD
from worker.analyses.orbits import ORBITS_ANALYSIS
from worker.analyses.run import read_analysis
from worker.stores.analysis_store import kind_of_store

ANALYSES: dict[str, Analysis] = {
    "bifurcation": BIFURCATION,
    "orbits": ORBITS_ANALYSIS,
    "manifold": MANIFOLD,
    "grazing_curve": GRAZING_CURVE,
}


def draw_analysis(location: str, target: str | Path | IO[bytes]) -> None:
    """Draw what the store of an analysis holds, complete or not, as a PNG.

    Parameters
    ----------
    location : str
        The store.
    target : path or binary file
        Where the PNG goes.

    Raises
    ------
    StoreConflict, StoreFailed
        Where there is no store of an analysis, or it cannot be read.
    """
    analysis = ANALYSES[kind_of_store(location)]
    job, columns, _ = read_analysis(analysis, location)
    figure = Figure(figsize=(10.0, 6.5), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    analysis.draw(job, columns, figure)
    # No date in the file: the same store gives the same bytes.
    figure.savefig(target, format="png", metadata={"Software": None})
