"""A real service in a process of its own, for tests that speak HTTP."""

import contextlib
import hashlib
import os
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import httpx2 as httpx
import psutil

from tests.object_store import BUCKET
from tests.ports import free_port
from tests.waiting import ended, wait_until
from worker.storage.location import result_location


@dataclass
class RunningService:
    """Where it is and what it keeps."""

    url: str
    data: Path
    process: subprocess.Popen
    results: str

    def store_of(self, job):
        """Place of a job's store, as `worker.results.opening.open_basin` takes it."""
        return result_location(self.results, job["id"])

    def runner(self):
        """Process that runs jobs, None while there is none."""
        with contextlib.suppress(psutil.NoSuchProcess):
            for child in psutil.Process(self.process.pid).children():
                with contextlib.suppress(psutil.NoSuchProcess):
                    if any("spawn_main" in part for part in child.cmdline()):
                        return child
        return None

    def signal(self, number):
        """Send a signal to the process that answers and to the one that runs jobs."""
        runner = self.runner()
        self.process.send_signal(number)
        if runner is not None:
            with contextlib.suppress(psutil.NoSuchProcess):
                runner.send_signal(number)

    def kill(self):
        """SIGKILL: nothing is put in order."""
        self.signal(signal.SIGKILL)
        self.process.wait(10)

    def why_not(self):
        """Why nothing more is to be expected of it; None while its process lives."""
        code = self.process.poll()
        return None if code is None else f"the service has ended with {code}: {(self.data / 'serve.log').read_text()}"

    def wait_until_ready(self, path="/readyz"):
        """Until it answers, and has workers: as long as its process lives."""
        what = f"{self.url}{path} answers 200, see {self.data / 'serve.log'}"
        wait_until(what, lambda: self._answers(path), self.why_not)

    def _answers(self, path):
        with contextlib.suppress(httpx.TransportError):
            return self.request("GET", path).status_code == 200

    def request(self, method, path, **options):
        """Answer to a request."""
        return httpx.request(method, self.url + path, timeout=30.0, **options)

    def submit(self, body, path=None):
        """Job of a request; without a path, for a basin or a sweep."""
        path = path or ("sweeps" if "vary" in body else "basins")
        answer = self.request("POST", f"/v1/{path}", json=body)
        assert answer.status_code == 202, answer.text
        return answer.json()

    def wait(self, job_id, until=ended):
        """State of a job once a condition holds; fails as soon as the job has ended without it."""
        seen = None

        def holds():
            nonlocal seen
            seen = self.request("GET", f"/v1/jobs/{job_id}").json()
            return until(seen)

        def possible():
            return f"it is {seen}" if ended(seen) else self.why_not()

        wait_until(f"a condition holds for the job {job_id}", holds, possible)
        return seen


@dataclass
class Backends:
    """Servers that services keep their jobs and results in, where tests are to use them."""

    postgresql: object = None
    object_store: object = None

    def variables(self, data):
        """Variables of a service whose data folder this is: the same folder, the same database and results."""
        if self.postgresql is None:
            return {}
        name = "service_" + hashlib.sha256(str(data).encode()).hexdigest()[:16]
        database = self.postgresql.new_database(name)
        return {"RATTLE_DATABASE_URL": database, "RATTLE_STORE": f"s3://{BUCKET}/{name}"}


BACKENDS = Backends()


@contextlib.contextmanager
def running_service(data, port=None, *, ready="/readyz", **environment):
    """Run ``rattle serve`` with two workers until the context ends; it is given once an address answers."""
    port = port or free_port()
    command = [
        sys.executable,
        "-c",
        "from rattle.cli import app; app()",
        "serve",
        "--port",
        str(port),
        "--data",
        str(data),
    ]
    settings = BACKENDS.variables(data) | {name: str(value) for name, value in environment.items()}
    variables = os.environ | settings
    log = open(Path(data) / "serve.log", "ab")
    process = subprocess.Popen(command, env=variables, stdout=log, stderr=log)
    results = settings.get("RATTLE_STORE", str(Path(data) / "results"))
    service = RunningService(f"http://127.0.0.1:{port}", Path(data), process, results)
    try:
        service.wait_until_ready(ready)
        yield service
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
            process.wait(30)
        log.close()
