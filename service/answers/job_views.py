"""Jobs as they are sent, kept until they change: to ask whether one has changed costs a third of what it says."""

import json
from collections.abc import Sequence
from typing import Any

from sqlalchemy import Engine, Row, Select, bindparam, select

from service.answers.conditional import Told, told
from service.answers.kept_answers import KeptAnswers
from service.errors import JobNotFound
from service.models.job import JobView
from service.records.engine import only_reads
from service.records.job_record import JobRecord, JobState
from service.records.jobs import Jobs
from worker.jobs.job import Job

_Edition = Row[int, str, int]
"""Number, id and revision of a job."""
_JOBS = JobRecord.__table__
_EDITIONS: Select[int, str, int] = select(_JOBS.c.number, _JOBS.c.id, _JOBS.c.revision)
# What is asked hundreds of times a second is built once.
_BY_ID = _EDITIONS.where(_JOBS.c.id == bindparam("job_id"))
_ANSWERING = _EDITIONS.where(_JOBS.c.answering == bindparam("digest"))


class JobViews:
    """The jobs that were asked for last, as `JobView` says them.

    Guarantees. What is told of a job is what the database holds when it is asked, whichever replica has changed it
    last. Memory is bounded.

    Parameters
    ----------
    engine : Engine
    jobs : Jobs
        In the engine's database.
    """

    def __init__(self, engine: Engine, jobs: Jobs) -> None:
        self._engine, self._jobs = only_reads(engine), jobs
        self._kept: KeptAnswers[int] = KeptAnswers()

    def of(self, job_id: str) -> Told:
        """A job by id.

        Raises
        ------
        JobNotFound
        """
        found = self._told(self._ask(_BY_ID, job_id=job_id))
        if not found:
            raise JobNotFound(f"there is no job {job_id}")
        return found[0]

    def answering(self, job: Job) -> tuple[str, Told] | None:
        """Id and view of the job that answers a request, where there is one."""
        editions = self._ask(_ANSWERING, digest=job.digest)
        found = self._told(editions)
        return (editions[0].id, found[0]) if found else None

    def page(self, before: int | None, size: int, state: JobState | None) -> str:
        """Up to `size` jobs, newest first, older than number `before`, as `JobPage` says them."""
        query = _EDITIONS.order_by(_JOBS.c.number.desc()).limit(size + 1)
        if before is not None:
            query = query.where(_JOBS.c.number < before)
        if state is not None:
            query = query.where(_JOBS.c.state == state)
        editions = self._ask(query)
        following = None
        if len(editions) > size:
            only = f"&state={state}" if state else ""
            following = f"/v1/jobs?size={size}&before={editions[size - 1].number}{only}"
        views = ",".join(view.body for view in self._told(editions[:size]))
        return f'{{"jobs":[{views}],"next":{json.dumps(following)}}}'

    def of_record(self, record: JobRecord) -> Told:
        """A job as a record says it."""
        view = told(JobView.from_record(record).model_dump_json(exclude_unset=True))
        return self._kept.keep(record.id, record.revision, view)

    def _ask(self, query: Select[int, str, int], **values: Any) -> Sequence[_Edition]:
        with self._engine.connect() as connection:
            return connection.execute(query, values).all()

    def _told(self, editions: Sequence[_Edition]) -> list[Told]:
        """Views of jobs in the same order, without those that were removed just now."""
        views: dict[str, Told] = {}
        for _, job_id, revision in editions:
            kept = self._kept.get(job_id)
            if kept is not None and kept[0] == revision:
                views[job_id] = kept[1]
        if changed := [edition.id for edition in editions if edition.id not in views]:
            views |= {record.id: self.of_record(record) for record in self._jobs.records(changed)}
        return [views[edition.id] for edition in editions if edition.id in views]
