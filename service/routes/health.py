"""Liveness, readiness, and metrics for Prometheus."""

from importlib.metadata import version

from fastapi import APIRouter, Response
from pydantic import BaseModel

from service.middleware import metrics
from service.routes.dependencies import JobsHere, ProbesHere, RunnerHere

router = APIRouter(tags=["health"])


class Health(BaseModel):
    """Liveness of the process."""

    status: str = "ok"
    version: str = version("gear-rattle")


class Readiness(BaseModel):
    """Whether the service has what it needs to compute."""

    ready: bool
    database: bool
    workers: int


@router.get("/healthz", summary="Liveness")
async def healthz() -> Health:
    """Whether the process answers."""
    return Health()


@router.get(
    "/readyz", summary="Readiness", responses={503: {"model": Readiness, "description": "something is missing"}}
)
async def readyz(response: Response, probes: ProbesHere) -> Readiness:
    """Whether the database, the scheduler and at least one worker answer, each within three seconds."""
    database, workers = await probes.database(), probes.workers()
    ready = database and workers > 0
    response.status_code = 200 if ready else 503
    return Readiness(ready=ready, database=database, workers=workers)


@router.get(
    "/metrics",
    response_class=Response,
    summary="Metrics",
    responses={200: {"description": "Prometheus' text format", "content": {"text/plain": {}}}},
)
def get_metrics(jobs: JobsHere, runner: RunnerHere) -> Response:
    """Metrics of this process, of the runner process, and of the jobs in the database."""
    return Response(metrics.exposition(jobs.count(), runner.metrics()), media_type=metrics.CONTENT_TYPE)
