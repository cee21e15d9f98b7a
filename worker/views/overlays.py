"""What can be laid over a basin of a store: computed from its oscillator and its catalogue."""

from worker.pictures.overlay import Overlay
from worker.pictures.overlay_kind import OverlayKind, overlays_for
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
        Up to the highest speed of the window, from zero on: a curve is not cut where a window begins.

    Raises
    ------
    InvalidJob
        Where there is no such basin, or its model has no such overlay.
    StoreConflict, StoreFailed
        Where there is no basin's store, or it cannot be read.
    """
    store = open_cells(location, basin)
    catalogue = catalogue_of(store, store.read_solutions(), basin)
    attractors = tuple(catalogue[number] for number in sorted(catalogue))
    return overlays_for((kind,), store.job.oscillator_of(basin), attractors, (0.0, store.job.grid.velocity_stop))
