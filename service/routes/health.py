"""Liveness and readiness."""

from fastapi import APIRouter, Response
from pydantic import BaseModel

from service.dependencies import JobsHere, RunnerHere

router = APIRouter(tags=["health"])


class Health(BaseModel):
    """The process answers."""

    status: str = "ok"


class Readiness(BaseModel):
    """What the service needs to compute."""

    ready: bool
    database: bool
    workers: int


@router.get("/healthz", summary="Liveness")
def healthz() -> Health:
    """Whether the process answers."""
    return Health()


@router.get(
    "/readyz", summary="Readiness", responses={503: {"model": Readiness, "description": "something is missing"}}
)
def readyz(response: Response, jobs: JobsHere, runner: RunnerHere) -> Readiness:
    """Whether the database, the scheduler and at least one worker answer."""
    database = jobs.answers()
    workers = runner.workers()
    ready = database and workers > 0
    response.status_code = 200 if ready else 503
    return Readiness(ready=ready, database=database, workers=workers)
