"""A service in a thread of this process, without the one that runs jobs: it starts at once, and jobs stay queued."""

import contextlib
import threading
from dataclasses import dataclass, field
from typing import Any

import httpx2 as httpx

from rattle_kernels import CellGrid
from service import app as application
from service.runner import metrics as run_metrics
from service.server import Server
from service.settings import Settings
from tests.running_service import free_port
from tests.waiting import wait_until
from worker.jobs.basin_job import BasinJob


class IdleRunner:
    """Runs nothing, and has as many workers as a test says."""

    def __init__(self, *_: Any) -> None:
        self.there = 2

    def start(self) -> None: ...
    def stop(self) -> None: ...
    def wake(self) -> None: ...
    def cancel(self, job_id: str) -> None: ...

    def workers(self) -> int:
        return self.there

    def metrics(self) -> bytes:
        return run_metrics.exposition()


@dataclass
class IdleService:
    url: str
    port: int
    app: Any
    headers: dict[str, str] = field(default_factory=dict)

    def request(self, method, path, **options):
        options["headers"] = self.headers | options.get("headers", {})
        return httpx.request(method, self.url + path, timeout=30.0, **options)

    @property
    def jobs(self):
        return self.app.state.jobs

    @property
    def results(self):
        return self.app.state.settings.results

    def add_job(self, cells=10, submitter="local"):
        grid = CellGrid(time_cells=cells, velocity_cells=cells)
        return self.jobs.submit(BasinJob(grid=grid, iterations=1), submitter)[0]


@contextlib.contextmanager
def idle_service(monkeypatch, data, **settings):
    """Run one until the context ends."""
    monkeypatch.setattr(application, "RunnerProcess", IdleRunner)
    port = free_port()
    asked = Settings(data=data, port=port, **settings)
    app = application.create_app(asked)
    server = Server(app, asked)
    thread = threading.Thread(target=server.run)
    thread.start()
    try:
        wait_until(
            "the service has started",
            lambda: server.started,
            lambda: None if thread.is_alive() else "it has ended",
            0.01,
        )
        yield IdleService(f"http://127.0.0.1:{port}", port, app)
    finally:
        server.should_exit = True
        wait_until("the service has stopped", lambda: not thread.is_alive(), pause=0.01)
