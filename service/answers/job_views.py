"""Jobs as JSON, cached by revision until the job changes. Reading a revision costs a third of reading a job."""

import json
import threading
from collections.abc import Sequence

from cachetools import LRUCache

from service.answers.conditional import JsonAnswer, json_answer
from service.errors import JobNotFound
from service.models.jobs import JobView
from service.records.job_record import JobRecord, JobState
from service.records.jobs import Jobs
from service.records.revisions import Revision, Revisions
from worker.jobs.job import Job

_CACHE_BYTES = 1 << 25
# A page ends with the jobs that exceed this. They are read a few at a time.
_PAGE_BYTES, _AT_ONCE = 1 << 20, 4
# Size of a cache entry without its text.
_ENTRY_BYTES = 1024


class JobViews:
    """Jobs as `JobView` describes them.

    Guarantees. A view is what the database holds at that moment, whichever replica changed the job last. Memory is
    bounded. Many threads may share one instance.

    Parameters
    ----------
    revisions : Revisions
    jobs : Jobs
        Jobs of the same database.
    """

    def __init__(self, revisions: Revisions, jobs: Jobs) -> None:
        self._revisions, self._jobs = revisions, jobs
        self._lock = threading.Lock()
        self._cache: LRUCache[tuple[str, int], JsonAnswer] = LRUCache(
            _CACHE_BYTES, getsizeof=lambda answer: _ENTRY_BYTES + len(answer.body)
        )

    def of(self, job_id: str) -> JsonAnswer:
        """A job by id.

        Raises
        ------
        JobNotFound
        """
        answers = self._render(self._revisions.of(job_id))
        if not answers:
            raise JobNotFound(f"there is no job {job_id}")
        return answers[0]

    def answering(self, job: Job) -> tuple[str, JsonAnswer] | None:
        """Id and view of the job that answers a request, if there is one."""
        revisions = self._revisions.answering(job.digest)
        answers = self._render(revisions)
        return (revisions[0].id, answers[0]) if answers else None

    def page(self, before: int | None, size: int, state: JobState | None) -> str:
        """Up to `size` jobs, newest first, older than number `before`, as `JobPage` describes them.

        A page of long requests has fewer jobs: its text is bounded.
        """
        revisions = self._revisions.page(before, size + 1, state)
        views: list[str] = []
        shown = 0
        while shown < min(size, len(revisions)) and sum(map(len, views)) < _PAGE_BYTES:
            some = revisions[shown : min(size, shown + _AT_ONCE)]
            views += [view.body for view in self._render(some)]
            shown += len(some)
        next_page = None
        if len(revisions) > shown:
            in_state = f"&state={state}" if state else ""
            next_page = f"/v1/jobs?size={size}&before={revisions[shown - 1].number}{in_state}"
        return f'{{"jobs":[{",".join(views)}],"next":{json.dumps(next_page)}}}'

    def of_record(self, record: JobRecord) -> JsonAnswer:
        """The job that a record describes."""
        view = json_answer(JobView.from_record(record).model_dump_json(exclude_unset=True))
        if len(view.body) + _ENTRY_BYTES <= _CACHE_BYTES:
            with self._lock:
                self._cache[record.id, record.revision] = view
        return view

    def _render(self, revisions: Sequence[Revision]) -> list[JsonAnswer]:
        """Views of jobs in the same order, without jobs that have just been deleted."""
        with self._lock:
            views = {each.id: self._cache.get((each.id, each.revision)) for each in revisions}
        if changed := [job_id for job_id, view in views.items() if view is None]:
            views |= {record.id: self.of_record(record) for record in self._jobs.records(changed)}
        return [view for view in views.values() if view is not None]
