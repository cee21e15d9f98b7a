"""Parts of a deployment on hosts of a network, with a database and an object store, and a client of the service."""

import contextlib
import os
import subprocess
import sys
import time
from pathlib import Path

import httpx2 as httpx

from tests.hosts.network import Network
from tests.hosts.supervisor import Supervisor
from tests.object_store import ObjectStore
from tests.postgresql import running_postgresql
from worker.cluster.certificates import make_certificates

ROOT = Path(__file__).parents[2]
BASIN = {"grid": {"time": {"cells": 400}, "velocity": {"cells": 400}}, "iterations": 1499}


def environment_of(part):
    """What a container's process has in its environment, and where this machine keeps programs and kernels."""
    here = {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
    return here | {"HOME": os.environ["HOME"]} | part.environment


class Cluster:
    """All parts, on their hosts."""

    def __init__(self, network, parts, objects, folder):
        self.network, self.objects, self.folder = network, objects, folder
        self.parts = {part.host: part for part in parts}
        self.running = {
            host: Supervisor(
                network.on(host, part.command), environment_of(part), part.restarts, folder / f"{host}.log"
            )
            for host, part in self.parts.items()
        }
        self.key = ""

    def add_key(self):
        """Make a key, as whoever installs the service does before it starts, and use it from now on."""
        self.key = self.once("service", ["rattle", "keys", "add", "tests", "--scope", "admin"]).split()[-1]

    def once(self, host, command):
        """Output of a command that is run on a host beside its part, as by `docker compose exec`."""
        command = self.network.on(host, command)
        environment = environment_of(self.parts[host])
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True, timeout=180).stdout

    def request(self, method, path, **options):
        """Answer of the service to a holder of the key."""
        url = f"http://{self.network.address('service')}:8000{path}"
        headers = {"authorization": f"Bearer {self.key}"}
        return httpx.request(method, url, headers=headers, timeout=30, **options)

    def wait(self, what, holds, seconds=240):
        """Wait until something holds."""
        patience = time.monotonic() + seconds
        while True:
            with contextlib.suppress(httpx.TransportError, subprocess.CalledProcessError):
                if found := holds():
                    return found
            assert time.monotonic() < patience, f"still waiting until {what}"
            time.sleep(0.3)

    def workers(self):
        """Workers that the scheduler knows."""
        return self.request("GET", "/readyz").json()["workers"]

    def submit(self):
        """A new job."""
        answer = self.request("POST", "/v1/basins", json=BASIN)
        assert answer.status_code == 202, answer.text
        return answer.json()["id"]

    def job(self, job_id):
        """State of a job."""
        return self.request("GET", f"/v1/jobs/{job_id}").json()

    def succeeded(self, job_id):
        """Whether it has; fails where it failed."""
        job = self.job(job_id)
        assert job["state"] not in ("failed", "cancelled"), job["error"]
        return job["state"] == "succeeded"

    def result(self, job_id):
        """Every object of a result; the root's metadata hold times and are left out."""
        found = self.objects.objects(f"gear-rattle/{job_id}.zarr")
        assert len(found) > 50
        return {path: content for path, content in found.items() if path != "zarr.json"}

    def start(self):
        """Start all parts, and wait until they are healthy. Returns what stops them."""
        stop = contextlib.ExitStack()
        for supervisor in self.running.values():
            stop.callback(supervisor.stop)
            supervisor.start()
        try:
            for host, part in self.parts.items():
                self.wait(f"{host} is healthy", lambda host=host, part=part: self.once(host, part.check) == "")
            self.wait("both workers are there", lambda: self.workers() == 2)
        except BaseException:
            for log in sorted(self.folder.glob("*.log")):
                print(log.name, log.read_text()[-3000:])
            stop.close()
            raise
        return stop


@contextlib.contextmanager
def hosts_of(parts, folder, password):
    """A cluster of these parts that has not been started, with a database and an object store on hosts of their own."""
    files = make_certificates(folder / "certs", 1)
    secrets = folder / "secrets"
    secrets.mkdir()
    for name, file in (("ca", files.authority), ("certificate", files.certificate), ("key", files.key)):
        (secrets / name).write_bytes(file.read_bytes())
    with contextlib.ExitStack() as stack:
        network = stack.enter_context(Network([*(part.host for part in parts), "database", "objects"], secrets))
        database = stack.enter_context(
            running_postgresql(listen="*", port=5432, on=lambda command: network.on("database", command))
        )
        database.new_role_with_database("rattle", password)
        objects = ObjectStore(network.address("objects"), 9000, on=lambda command: network.on("objects", command))
        stack.callback(objects.kill)
        objects.start()
        yield Cluster(network, parts, objects, folder)
