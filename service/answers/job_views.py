"""Jobs as JSON."""

import json

from service.answers.conditional import JsonAnswer, json_answer
from service.models.jobs import JobView
from service.records.job_record import JobRecord, JobState
from service.records.jobs import Jobs

# A page ends with the jobs that exceed this. They are read a few at a time.
_PAGE_BYTES, _AT_ONCE = 1 << 20, 10


def view_of(record: JobRecord) -> JsonAnswer:
    """A job, as `JobView` describes it."""
    return json_answer(JobView.from_record(record).model_dump_json(exclude_unset=True))


def page_of(jobs: Jobs, before: int | None, size: int, state: JobState | None) -> str:
    """Up to `size` jobs, newest first, older than number `before`, as `JobPage` describes them.

    A page of long requests has fewer jobs: its text is bounded.
    """
    views: list[str] = []
    more = True
    while more and len(views) < size and sum(map(len, views)) < _PAGE_BYTES:
        most = min(_AT_ONCE, size - len(views))
        records = jobs.page(before, most + 1, state)
        views += [view_of(record).body for record in records[:most]]
        more = len(records) > most
        before = records[:most][-1].number if records else before
    in_state = f"&state={state}" if state else ""
    next_page = f"/v1/jobs?size={size}&before={before}{in_state}" if more else None
    return f'{{"jobs":[{",".join(views)}],"next":{json.dumps(next_page)}}}'
