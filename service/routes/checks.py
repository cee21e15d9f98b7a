"""Requests checked, but not recorded."""

from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Body

from service.answers.checks import CheckView, check_request
from service.routes.dependencies import ChecksHere, SettingsHere, problems
from service.routes.plain_json import PlainJsonRoute

router = APIRouter(prefix="/v1", tags=["submit"], route_class=PlainJsonRoute)


@router.post(
    "/checks",
    summary="Check a request",
    responses=problems(s400="malformed JSON", s413="body too large", s422="the body is no JSON object"),
)
async def check(body: Annotated[dict[str, Any], Body()], settings: SettingsHere, checks: ChecksHere) -> CheckView:
    """Check whether a request would be accepted, and how long it takes; if not, why not; and which bounds apply.

    A request of any kind: the one that it names, or else a basin, or with `vary` or `design` a sweep.

    Nothing is recorded. The errors are those of the submission.
    """
    return await checks.run(partial(check_request, body, settings))
