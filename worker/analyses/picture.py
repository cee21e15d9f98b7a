"""The picture of a store, whatever its kind."""

from matplotlib.figure import Figure

from worker.analyses.run import read_analysis
from worker.errors import InvalidJob
from worker.kinds import KINDS
from worker.pictures.figure_file import new_figure
from worker.pictures.panel_picture import USUAL_LOOK, Look
from worker.pictures.picture import basin_figure
from worker.stores.analysis_store import kind_of_store


def figure_of_store(location: str, look: Look = USUAL_LOOK) -> Figure:
    """Draw a store, complete or not: its basins, or the result of an analysis.

    Parameters
    ----------
    location : str
    look : Look
        How basins are drawn.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidJob
        If the store has no such layer, overlay, window or panel.
    StoreConflict, StoreFailed
        If there is no store, or it cannot be read.
    """
    kind = KINDS[kind_of_store(location)]
    if kind.analysis is None:
        return basin_figure(location, look)
    if look.window is not None or look.panel is not None:
        raise InvalidJob("only basins and sweeps have a window and a panel: leave them out")
    job, columns, _ = read_analysis(kind.loaded_analysis, location)
    figure = new_figure(10.0, 6.5)
    kind.loaded_analysis.draw(job, columns, figure)
    return figure
