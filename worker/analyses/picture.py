"""Pictures of analyses, whatever their kind."""

from pathlib import Path
from typing import IO

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from worker.analyses.run import read_analysis
from worker.kinds import KINDS
from worker.stores.analysis_store import kind_of_store


def draw_analysis(location: str, target: str | Path | IO[bytes]) -> None:
    """Draw the store of an analysis, complete or not, as a PNG.

    Parameters
    ----------
    location : str
        The store.
    target : path or binary file
        Where the PNG goes.

    Raises
    ------
    StoreConflict, StoreFailed
        If there is no store of an analysis, or it cannot be read.
    """
    analysis = KINDS[kind_of_store(location)].loaded_analysis
    job, columns, _ = read_analysis(analysis, location)
    figure = Figure(figsize=(10.0, 6.5), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    analysis.draw(job, columns, figure)
    # No date in the file: the same store gives the same bytes.
    figure.savefig(target, format="png", metadata={"Software": None})
