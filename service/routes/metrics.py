"""Metrics, for Prometheus."""

from fastapi import APIRouter, Response

from service import metrics
from service.dependencies import JobsHere

router = APIRouter(tags=["health"])


@router.get(
    "/metrics",
    response_class=Response,
    summary="Metrics",
    responses={200: {"description": "Prometheus' text format", "content": {"text/plain": {}}}},
)
def get_metrics(jobs: JobsHere) -> Response:
    """Of this process, and of the jobs in its database."""
    return Response(metrics.exposition(jobs.count()), media_type=metrics.CONTENT_TYPE)
