"""Overlays of a basin of a store, computed from its oscillator and its catalogue."""

from worker.errors import InvalidJob
from worker.pictures.overlay import Overlay
from worker.pictures.overlay_kind import OverlayKind, masks_among, overlays_for
from worker.views.outline import catalogue_of, open_cells


def overlay_basin(location: str, basin: int, kind: OverlayKind) -> tuple[Overlay, ...]:
    """Overlays of one kind for a basin of the store at a location.

    Parameters
    ----------
    location : str
    basin : int
    kind : OverlayKind

    Returns
    -------
    tuple of Overlay
        From speed zero to the highest of the window, so curves are not cut where the window begins.

    Raises
    ------
    InvalidJob
        If there is no such basin, or its model lacks the overlay; or if cells have it, which come tile by tile.
    StoreConflict, StoreFailed
        If there is no basin's store, or it cannot be read.
    """
    if masks_among((kind,)):
        raise InvalidJob(f"what is {kind} comes with the cells, tile by tile: see tiles")
    store = open_cells(location, basin)
    catalogue = catalogue_of(store, store.solutions.read(), basin)
    attractors = tuple(catalogue[number] for number in sorted(catalogue))
    return overlays_for((kind,), store.job.oscillator_of(basin), attractors, (0.0, store.job.grid.velocity_stop))
