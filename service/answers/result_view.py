"""Results of jobs of every kind: in short, and as a picture."""

import dataclasses
from typing import IO

from service.errors import NotReady
from service.models.basin_result import ResultView
from service.models.results import ANALYSIS_VIEWS, AnyAnalysisView, AnyResult
from service.records.job_record import JobRecord
from worker.analyses.kinds import draw_analysis
from worker.analyses.run import fingerprint_of_analysis, summarise_analysis
from worker.kinds import KINDS
from worker.pictures.panel_picture import Layer
from worker.pictures.picture import draw_basin
from worker.stores.opening import holds_store
from worker.stores.result_files import result_location
from worker.stores.summary import fingerprint, summarise


def place_of_result(record: JobRecord, results: str) -> str:
    """Place of a job's store below the folder of all results, once there is one.

    Raises
    ------
    NotReady
    """
    location = result_location(results, record.store or record.id)
    if not holds_store(location):
        raise NotReady(f"job {record.id} is {record.state} and has no result yet")
    return location


def result_view(kind: str, location: str, zarr: str) -> AnyResult:
    """View of the result of a job of a kind, whose store is at a location and over HTTP at a path.

    Raises
    ------
    StoreConflict, StoreFailed
    """
    if KINDS[kind].analysis is None:
        return ResultView.from_summary(summarise(location), zarr)
    fields = dataclasses.asdict(summarise_analysis(KINDS[kind].loaded_analysis, location))
    return ANALYSIS_VIEWS.get(kind, AnyAnalysisView)(**fields | fields.pop("told"), zarr=zarr)


def draw_result(kind: str, location: str, target: IO[bytes], layer: Layer) -> None:
    """Draw the result of a job of a kind; the layer is that of a basin's cells."""
    if KINDS[kind].analysis is None:
        draw_basin(location, target, layer=layer)
    else:
        draw_analysis(location, target)


def result_fingerprint(kind: str, location: str) -> bytes:
    """What changes whenever a picture of the result does."""
    return fingerprint(location) if KINDS[kind].analysis is None else fingerprint_of_analysis(location)
