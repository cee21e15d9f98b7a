"""Results of jobs of every kind: in short, and as a picture."""

import dataclasses
from typing import IO

from pydantic import TypeAdapter

from service.errors import NotReady
from service.models.analysis_requests import AnalysisResult
from service.models.models import ResultView
from service.records.job_record import JobRecord
from worker.analyses.kinds import ANALYSES, draw_analysis
from worker.analyses.run import fingerprint_of_analysis, summarise_analysis
from worker.pictures.panel_picture import Layer
from worker.pictures.picture import draw_basin
from worker.stores.opening import holds_store
from worker.stores.result_files import result_location
from worker.stores.summary import fingerprint, summarise

_ANALYSIS_RESULT: TypeAdapter[AnalysisResult] = TypeAdapter(AnalysisResult)


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


def result_view(kind: str, location: str, zarr: str) -> ResultView | AnalysisResult:
    """View of the result of a job of a kind, whose store is at a location and over HTTP at a path.

    Raises
    ------
    StoreConflict, StoreFailed
    """
    if kind not in ANALYSES:
        return ResultView.from_summary(summarise(location), zarr)
    fields = dataclasses.asdict(summarise_analysis(ANALYSES[kind], location))
    return _ANALYSIS_RESULT.validate_python(fields | fields.pop("result") | {"zarr": zarr})


def draw_result(kind: str, location: str, target: IO[bytes], layer: Layer) -> None:
    """Draw the result of a job of a kind; the layer is that of a basin's cells."""
    if kind in ANALYSES:
        draw_analysis(location, target)
    else:
        draw_basin(location, target, layer=layer)


def result_fingerprint(kind: str, location: str) -> bytes:
    """What changes whenever a picture of the result does."""
    return fingerprint_of_analysis(location) if kind in ANALYSES else fingerprint(location)
