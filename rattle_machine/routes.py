"""The page of a report over HTTP."""

from fastapi import APIRouter, Response

from rattle_machine.analysis import REPORT, page_in
from service.answers.conditional import NOT_MODIFIED, IfNoneMatch, etag_of, not_modified
from service.errors import NotReady
from service.routes.dependencies import LARGE, JobId, JobsHere, SettingsHere, problems, require_kind
from service.routes.results import location_of

# Its style stands in the page, and its pictures hold images. It runs nothing, and asks for nothing.
_POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
router = APIRouter(prefix="/v1/jobs/{job_id}", tags=["results"])


@router.get(
    "/report.html",
    summary="The page of a report",
    response_class=Response,
    responses={
        200: {"content": {"text/html": {}}},
        **problems(
            s404="there is no such job, or it has not begun",
            s409="the job is no report, or its page is not there yet",
        ),
        **NOT_MODIFIED,
    },
    dependencies=[LARGE],
)
def get_report(job_id: JobId, jobs: JobsHere, settings: SettingsHere, if_none_match: IfNoneMatch = None) -> Response:
    """One page that prints, with its pictures inside: what a machine does, how loud, how often, and which tolerance."""
    require_kind(jobs.get(job_id), "a page", "report")
    _, columns, store = REPORT.read(location_of(job_id, jobs, settings))
    if not store.complete:
        raise NotReady(f"the page of job {job_id} is not there yet")
    page = page_in(columns)
    etag = etag_of(page)
    answer = not_modified(etag, if_none_match) or Response(page, media_type="text/html", headers={"etag": etag})
    # Also where nothing has changed: a browser takes the headers of a 304 for those of what it has.
    answer.headers["content-security-policy"] = _POLICY
    return answer
