"""What Prometheus is told: of this process, and of the jobs in its database."""

from collections.abc import Iterator, Mapping

from prometheus_client import CONTENT_TYPE_LATEST, CollectorRegistry, Counter, Gauge, Histogram, generate_latest
from prometheus_client.core import CounterMetricFamily, Metric
from prometheus_client.process_collector import ProcessCollector
from prometheus_client.registry import Collector

from service.job_record import JobState
from worker.driver import tasks_retried
from worker.progress import Progress, Stage

CONTENT_TYPE = CONTENT_TYPE_LATEST
_REGISTRY = CollectorRegistry()
ProcessCollector(registry=_REGISTRY)
_JOBS = Gauge("rattle_jobs", "Jobs in the database", ["state"], registry=_REGISTRY)
_WAIT = Histogram(
    "rattle_queue_wait_seconds", "Time from a job's submission to its first start", registry=_REGISTRY,
    buckets=(0.1, 0.5, 1, 2, 5, 10, 30, 60, 300, 1800, 7200, 43200),
)  # fmt: skip
_TILES = Counter("rattle_tiles", "Tiles done by jobs that run from here", ["stage"], registry=_REGISTRY)
_CELLS = Counter("rattle_cells", "Cells mapped by jobs that run from here", registry=_REGISTRY)
_ENDED = Counter("rattle_jobs_ended", "Jobs that have ended here", ["state"], registry=_REGISTRY)
_LEASES = Counter("rattle_leases_lost", "Jobs that another replica took over from this one", registry=_REGISTRY)
_REQUESTS = Histogram(
    "rattle_request_seconds", "Time until an answer began", ["method", "route", "status"], registry=_REGISTRY,
    buckets=(0.002, 0.005, 0.01, 0.025, 0.05, 0.1, 0.15, 0.25, 0.5, 1, 2.5, 10),
)  # fmt: skip


class _Retries(Collector):
    """Counted by the worker, which knows of no metrics."""

    def collect(self) -> Iterator[Metric]:
        """As Prometheus asks for them."""
        yield CounterMetricFamily("rattle_task_retries", "Tasks submitted again after they were lost", tasks_retried())


_REGISTRY.register(_Retries())


def job_started(waited: float) -> None:
    """Note that a job has started for the first time, and how many seconds it had waited."""
    _WAIT.observe(max(0.0, waited))


def job_ended(state: JobState) -> None:
    """Note that a job has ended."""
    _ENDED.labels(state).inc()


def lease_lost() -> None:
    """Note that another replica has taken over a job of this one."""
    _LEASES.inc()


def answered(method: str, route: str, status: int, seconds: float) -> None:
    """Note an answer: to which route of the API, and how long until it began."""
    _REQUESTS.labels(method, route, status).observe(seconds)


def exposition(jobs: Mapping[JobState, int]) -> bytes:
    """All metrics as Prometheus reads them, given how many jobs there are."""
    for state in JobState:
        _JOBS.labels(state).set(jobs.get(state, 0))
    return generate_latest(_REGISTRY)


class Pace:
    """Counts the tiles and cells of one run of a job, from what it reports.

    Tiles that were in the store when a job was resumed count as done in its first report, and not here.
    """

    def __init__(self) -> None:
        self._last: Progress | None = None

    def __call__(self, progress: Progress) -> None:
        """Count what has been done since the last report."""
        last, self._last = self._last, progress
        if last is None or last.stage != progress.stage:
            return
        _TILES.labels(progress.stage).inc(max(0, progress.tiles_done - last.tiles_done))
        if progress.stage is Stage.MAPPING:
            _CELLS.inc(max(0, progress.cells_done - last.cells_done))
