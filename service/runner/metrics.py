"""Metrics of the runner process, for Prometheus. The service passes them on with its own."""

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest
from prometheus_client.process_collector import ProcessCollector

from service.records.job_record import JobState
from worker.progress import Progress, Stage

_REGISTRY = CollectorRegistry()
ProcessCollector(namespace="rattle_runner", registry=_REGISTRY)
_WAIT = Histogram(
    "rattle_queue_wait_seconds", "Time from a job's submission to its first start", registry=_REGISTRY,
    buckets=(0.1, 0.5, 1, 2, 5, 10, 30, 60, 300, 1800, 7200, 43200),
)  # fmt: skip
_TILES = Counter("rattle_tiles", "Tiles done by jobs that run from here", ["stage"], registry=_REGISTRY)
_CELLS = Counter("rattle_cells", "Cells mapped by jobs that run from here", registry=_REGISTRY)
_ENDED = Counter("rattle_jobs_ended", "Jobs that have ended here", ["state"], registry=_REGISTRY)
_LEFT = Gauge("rattle_tiles_left", "Tiles that jobs running here have left in their stage", registry=_REGISTRY)
_RETRIES = Counter("rattle_task_retries", "Tasks submitted again after they were lost", registry=_REGISTRY)
_LEASES = Counter("rattle_leases_lost", "Jobs that another replica took over from this one", registry=_REGISTRY)

_DELETED = Counter("rattle_results_deleted", "Jobs that were deleted, as nobody read their results", registry=_REGISTRY)


def job_started(waited: float) -> None:
    """Record that a job has started for the first time, and the seconds it was queued."""
    _WAIT.observe(max(0.0, waited))


def job_ended(state: JobState) -> None:
    """Record that a job has ended."""
    _ENDED.labels(state).inc()


def task_retried() -> None:
    """Record that a lost task has been submitted again."""
    _RETRIES.inc()


def lease_lost() -> None:
    """Record that another replica has taken over a job of this one."""
    _LEASES.inc()


def result_deleted() -> None:
    """Record that a job has been deleted with its result."""
    _DELETED.inc()


def exposition() -> bytes:
    """All metrics in Prometheus' text format."""
    return generate_latest(_REGISTRY)


class Pace:
    """Counts the tiles and cells of one run of a job, done and left, from its progress reports.

    Tiles that a resumed job finds in its store are in its first report and are not counted as done.
    """

    def __init__(self) -> None:
        self._last: Progress | None = None
        self._left = 0

    def __call__(self, progress: Progress) -> None:
        """Count the tiles and cells since the last report."""
        last, self._last = self._last, progress
        self._leave(progress.tiles_total - progress.tiles_done)
        if last is None or last.stage != progress.stage:
            return
        _TILES.labels(progress.stage).inc(max(0, progress.tiles_done - last.tiles_done))
        if progress.stage is Stage.MAPPING:
            _CELLS.inc(max(0, progress.cells_done - last.cells_done))

    def end(self) -> None:
        """Count no tile as left: the run is over, whether or not the job is."""
        self._leave(0)

    def _leave(self, left: int) -> None:
        _LEFT.inc(left - self._left)
        self._left = left
