"""Metrics, for Prometheus."""

from fastapi import APIRouter, Response

from service.middleware import metrics
from service.routes.dependencies import JobsHere, RunnerHere

router = APIRouter(tags=["health"])


@router.get(
    "/metrics",
    response_class=Response,
    summary="Metrics",
    responses={200: {"description": "Prometheus' text format", "content": {"text/plain": {}}}},
)
def get_metrics(jobs: JobsHere, runner: RunnerHere) -> Response:
    """Metrics of this process, of the runner process, and of the jobs in the database."""
    return Response(metrics.exposition(jobs.count(), runner.metrics()), media_type=metrics.CONTENT_TYPE)
