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
    """Of this process, of the one that runs jobs, and of the jobs in their database."""
    return Response(metrics.exposition(jobs.count(), runner.metrics()), media_type=metrics.CONTENT_TYPE)
