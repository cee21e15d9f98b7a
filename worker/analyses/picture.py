"""The picture of a store, whatever its kind."""

from collections.abc import Collection

from matplotlib.figure import Figure

from worker.analyses.run import read_analysis
from worker.kinds import KINDS
from worker.pictures.figure_file import new_figure
from worker.pictures.overlay_kind import USUAL_OVERLAYS, OverlayKind
from worker.pictures.panel_picture import Layer
from worker.pictures.picture import basin_figure
from worker.stores.analysis_store import kind_of_store


def figure_of_store(
    location: str, *, layer: Layer = Layer.SOLUTION, overlays: Collection[OverlayKind] = USUAL_OVERLAYS
) -> Figure:
    """Draw a store, complete or not: its basins, or the result of an analysis.

    Parameters
    ----------
    location : str
    layer : Layer
        Quantity of a basin's cells to draw.
    overlays : collection of OverlayKind
        Overlays drawn on each basin.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidJob
        If the layer or an overlay is not known for the store.
    StoreConflict, StoreFailed
        If there is no store, or it cannot be read.
    """
    kind = KINDS[kind_of_store(location)]
    if kind.analysis is None:
        return basin_figure(location, layer=layer, overlays=overlays)
    job, columns, _ = read_analysis(kind.loaded_analysis, location)
    figure = new_figure(10.0, 6.5)
    kind.loaded_analysis.draw(job, columns, figure)
    return figure
