"""Results of jobs of every kind: summaries and pictures."""

import dataclasses
import threading
from typing import IO

from cachetools import TTLCache, cached
from pydantic import TypeAdapter

from service.answers.conditional import JsonAnswer, json_answer
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
# A driver writes down its progress as often. To read a summary costs as much as ten reads of a job's status.
_SUMMARY_SECONDS, _SUMMARY_BYTES = 0.5, 1 << 25
_SUMMARIES: TTLCache[tuple[str, int], JsonAnswer] = TTLCache(
    _SUMMARY_BYTES, _SUMMARY_SECONDS, getsizeof=lambda answer: len(answer.body)
)


def location_of_result(record: JobRecord, results: str) -> str:
    """Location of a job's store below the folder of all results.

    Raises
    ------
    NotReady
        While the job has no store.
    """
    location = result_location(results, record.store or record.id)
    if not holds_store(location):
        raise NotReady(f"job {record.id} is {record.state} and has no result yet")
    return location


# The revision rises with each change of state: what was read before the end is not given as the result.
@cached(_SUMMARIES, key=lambda record, results: (record.id, record.revision), condition=threading.Condition())
def summary_of_result(record: JobRecord, results: str) -> JsonAnswer:
    """Summary of a job's result, at most half a second old; of many threads that ask for one at once, one reads it.

    Raises
    ------
    NotReady, StoreConflict, StoreFailed
    """
    view = _result_view(record.kind, location_of_result(record, results), f"/v1/jobs/{record.id}/result.zarr")
    return json_answer(view.model_dump_json())


def _result_view(kind: str, location: str, zarr: str) -> ResultView | AnalysisResult:
    """View of a result whose store is at a location and over HTTP at a path."""
    if kind not in ANALYSES:
        return ResultView.from_summary(summarise(location), zarr)
    fields = dataclasses.asdict(summarise_analysis(ANALYSES[kind], location))
    return _ANALYSIS_RESULT.validate_python(fields | fields.pop("told") | {"zarr": zarr})


def draw_result(kind: str, location: str, target: IO[bytes], layer: Layer) -> None:
    """Draw the result of a job; `layer` selects what is drawn of a basin's cells."""
    if kind in ANALYSES:
        draw_analysis(location, target)
    else:
        draw_basin(location, target, layer=layer)


def result_fingerprint(kind: str, location: str) -> bytes:
    """Bytes that change whenever the picture of the result does."""
    return fingerprint_of_analysis(location) if kind in ANALYSES else fingerprint(location)
