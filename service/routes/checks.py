"""Requests checked, but not recorded."""

from typing import Annotated, Any

from fastapi import APIRouter, Body

from service.answers.checks import CheckView, check_request
from service.routes.dependencies import SettingsHere, problems
from service.routes.plain_json import PlainJsonRoute

router = APIRouter(prefix="/v1", tags=["submit"], route_class=PlainJsonRoute)


@router.post(
    "/checks",
    summary="Check a request",
    responses=problems(s400="malformed JSON", s413="body too large", s422="the body is no JSON object"),
)
def check(body: Annotated[dict[str, Any], Body()], settings: SettingsHere) -> CheckView:
    """Say whether a basin, or with `vary` a sweep, would be accepted, why not, and what bounds hold.

    Nothing is recorded. The errors are those that the submission would be refused with.
    """
    return check_request(body, settings)
