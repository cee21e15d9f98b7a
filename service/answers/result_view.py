"""Results of jobs of every kind: summaries and pictures."""

from service.answers.conditional import JsonAnswer, json_answer
from service.errors import NotReady
from service.records.job_record import JobRecord, JobState
from worker.kinds import KINDS
from worker.storage.location import holds_root, result_location
from worker.stores.opening import holds_store


def location_of_result(record: JobRecord, results: str) -> str:
    """Location of a job's store below the folder of all results.

    Raises
    ------
    NotReady
        While the job has no store.
    """
    location = result_location(results, record.store or record.id)
    if not holds_store(location):
        if record.state == JobState.SUCCEEDED:
            raise NotReady(f"the result of job {record.id} is gone: send its request again, to compute it anew")
        if record.state.final:
            raise NotReady(f"job {record.id} is {record.state}, and there is no result: send its request again")
        raise NotReady(f"job {record.id} is {record.state} and has no result yet")
    return location


def result_is_gone(record: JobRecord, results: str) -> bool:
    """Whether the result of a job that has succeeded was removed by somebody."""
    if record.state != JobState.SUCCEEDED:
        return False
    return not holds_root(result_location(results, record.store or record.id))


def summary_of_result(record: JobRecord, results: str) -> JsonAnswer:
    """Summary of a job's result.

    Raises
    ------
    NotReady, StoreConflict, StoreFailed
    """
    kind, location = KINDS[record.kind], location_of_result(record, results)
    return json_answer(kind.summarise(location, f"/v1/jobs/{record.id}/result.zarr").model_dump_json())
