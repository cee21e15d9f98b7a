"""Metrics for Prometheus: of this process, of the runner process, and of the jobs in the database."""

from collections.abc import Mapping
from importlib.metadata import version

from prometheus_client import CONTENT_TYPE_LATEST, CollectorRegistry, Gauge, Histogram, Info, generate_latest
from prometheus_client.process_collector import ProcessCollector

from service.records.job_record import JobState

CONTENT_TYPE = CONTENT_TYPE_LATEST
_REGISTRY = CollectorRegistry()
ProcessCollector(registry=_REGISTRY)
_JOBS = Gauge("rattle_jobs", "Jobs in the database", ["state"], registry=_REGISTRY)
Info("rattle", "Version of the service", registry=_REGISTRY).info({"version": version("gear-rattle")})
_REQUESTS = Histogram(
    "rattle_request_seconds", "Time until an answer began", ["method", "route", "status"], registry=_REGISTRY,
    buckets=(0.002, 0.005, 0.01, 0.025, 0.05, 0.1, 0.15, 0.25, 0.5, 1, 2.5, 10),
)  # fmt: skip


def record_answer(method: str, route: str, status: int, seconds: float) -> None:
    """Record a response: the route, and the time until the response began."""
    _REQUESTS.labels(method, route, status).observe(seconds)


def exposition(jobs: Mapping[JobState, int], runner: bytes) -> bytes:
    """All metrics in Prometheus' text format, from the number of jobs in each state and the runner's metrics."""
    for state in JobState:
        _JOBS.labels(state).set(jobs.get(state, 0))
    return generate_latest(_REGISTRY) + runner
