"""Revisions of jobs. A response made from the current revision is still valid."""

from typing import Any, NamedTuple

from sqlalchemy import Engine, Select, bindparam, select

from service.records.engine import only_reads
from service.records.job_record import JobRecord, JobState

_JOBS = JobRecord.__table__
_REVISIONS: Select[int, str, int] = select(_JOBS.c.number, _JOBS.c.id, _JOBS.c.revision)
# Statements that run hundreds of times a second are built once.
_BY_ID = _REVISIONS.where(_JOBS.c.id == bindparam("job_id"))
_ANSWERING = _REVISIONS.where(_JOBS.c.answering == bindparam("digest"))


class Revision(NamedTuple):
    """Number and id of a job, and how often it has changed."""

    number: int
    id: str
    revision: int


class Revisions:
    """The revisions of the jobs in a database. Plain queries: they cost a third of reading the records.

    Parameters
    ----------
    engine : Engine
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = only_reads(engine)

    def of(self, job_id: str) -> list[Revision]:
        """Revision of the job with this id, if it exists."""
        return self._select(_BY_ID, job_id=job_id)

    def answering(self, digest: str) -> list[Revision]:
        """Revision of the job that answers the request with this digest, if there is one."""
        return self._select(_ANSWERING, digest=digest)

    def page(self, before: int | None, size: int, state: JobState | None) -> list[Revision]:
        """Revisions of up to `size` jobs, newest first; optionally older than number `before` or in one state."""
        query = _REVISIONS.order_by(_JOBS.c.number.desc()).limit(size)
        if before is not None:
            query = query.where(_JOBS.c.number < before)
        if state is not None:
            query = query.where(_JOBS.c.state == state)
        return self._select(query)

    def _select(self, query: Select[int, str, int], **values: Any) -> list[Revision]:
        with self._engine.connect() as connection:
            return [Revision(*row) for row in connection.execute(query, values)]
