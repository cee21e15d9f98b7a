"""Time histories, computed while the client waits."""

from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Query
from starlette.concurrency import run_in_threadpool

from service.errors import LimitExceeded
from service.models.requests import described_as, parsed
from service.models.results import TrajectoryView
from service.routes.dependencies import LARGE, ChecksHere, SettingsHere, problems
from service.routes.plain_json import PlainJsonRoute
from worker.jobs.trajectory_request import TrajectoryRequest
from worker.results.motion_end import FOLLOWED_PERIODS, end_of

router = APIRouter(prefix="/v1", tags=["trajectories"], route_class=PlainJsonRoute)
_BODY: Any = described_as(TrajectoryRequest, machine=True)


@router.post(
    "/trajectories",
    summary="Follow one motion",
    dependencies=[LARGE],
    responses=problems(
        s400="malformed JSON", s413="body too large", s422="what is wrong with the request, field by field"
    ),
)
async def follow_trajectory(
    body: _BODY,
    settings: SettingsHere,
    checks: ChecksHere,
    end: Annotated[
        bool, Query(description=f"Follow a departure from +beta for {FOLLOWED_PERIODS} periods, and say what it does")
    ] = False,
) -> TrajectoryView:
    """Compute the time history from an initial condition, of either model, and list its contacts."""
    request = await checks.run(partial(parsed, TrajectoryRequest, body))
    samples = request.periods * request.samples_per_period
    if samples > settings.max_samples:
        raise LimitExceeded(
            f"{samples:.0f} samples (periods times samples_per_period) are more than the limit of "
            f"{settings.max_samples}"
        )

    def follow() -> TrajectoryView:
        history = request.follow(settings.max_contacts)
        return TrajectoryView.from_history(history, end_of(request, settings.max_contacts) if end else None)

    return await run_in_threadpool(follow)
