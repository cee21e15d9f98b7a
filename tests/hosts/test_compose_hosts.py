"""The compose file's commands on hosts of a network: a basin, a host that is cut off and comes back, the same bytes."""

import contextlib
import os
import subprocess
import sys
import time
from pathlib import Path

import httpx2 as httpx
import pytest

from rattle_kernels import warm_up
from tests.hosts.compose import parts_of_compose_file
from tests.hosts.network import Network
from tests.hosts.supervisor import Supervisor
from tests.object_store import ObjectStore
from tests.postgresql import running_postgresql
from worker.cluster.certificates import make_certificates

pytestmark = pytest.mark.hosts

ROOT = Path(__file__).parents[2]
SECRETS = {"DATABASE_PASSWORD": "secret-1", "OBJECTS_ACCESS_KEY": "tests", "OBJECTS_SECRET_KEY": "no secret"}
BASIN = {"grid": {"time": {"cells": 400}, "velocity": {"cells": 400}}, "iterations": 1499}


def environment_of(part):
    """What a container's process has in its environment, and where this machine keeps programs and kernels."""
    here = {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
    return here | {"HOME": os.environ["HOME"]} | part.environment


class Cluster:
    """All parts, on their hosts."""

    def __init__(self, network, parts, objects, folder):
        self.network, self.objects = network, objects
        self.parts = {part.host: part for part in parts}
        self.running = {
            host: Supervisor(
                network.on(host, part.command), environment_of(part), part.restarts, folder / f"{host}.log"
            )
            for host, part in self.parts.items()
        }
        self.key = ""

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


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    if os.geteuid() != 0:
        pytest.skip("network namespaces take root")
    warm_up()  # as in the image, no worker has to compile
    folder = tmp_path_factory.mktemp("hosts")
    files = make_certificates(folder / "certs", 1)
    secrets = folder / "secrets"
    secrets.mkdir()
    for name, file in (("ca", files.authority), ("certificate", files.certificate), ("key", files.key)):
        (secrets / name).write_bytes(file.read_bytes())
    parts = parts_of_compose_file(SECRETS)
    hosts = [part.host for part in parts]
    with contextlib.ExitStack() as stack:
        network = stack.enter_context(Network([*hosts, "database", "objects"], secrets))
        database = stack.enter_context(
            running_postgresql(listen="*", port=5432, on=lambda command: network.on("database", command))
        )
        database.new_role_with_database("rattle", SECRETS["DATABASE_PASSWORD"])
        objects = ObjectStore(network.address("objects"), 9000, on=lambda command: network.on("objects", command))
        stack.callback(objects.kill)
        objects.start()
        cluster = Cluster(network, parts, objects, folder)
        cluster.key = cluster.once("service", ["rattle", "keys", "add", "tests", "--scope", "admin"]).split()[-1]
        for supervisor in cluster.running.values():
            stack.callback(supervisor.stop)
            supervisor.start()
        try:
            for host, part in cluster.parts.items():
                cluster.wait(f"{host} is healthy", lambda host=host, part=part: cluster.once(host, part.check) == "")
            cluster.wait("both workers are there", lambda: cluster.workers() == 2)
        except BaseException:
            for log in sorted(folder.glob("*.log")):
                print(log.name, log.read_text()[-3000:])
            raise
        yield cluster


@pytest.fixture(scope="module")
def undisturbed(cluster):
    job = cluster.submit()
    cluster.wait("the basin is complete", lambda: cluster.succeeded(job))
    objects = cluster.result(job)
    # The same request is the same job as long as that is there.
    assert cluster.request("DELETE", f"/v1/jobs/{job}").status_code == 204
    assert cluster.objects.objects("gear-rattle") == {}
    return objects


def test_a_worker_that_is_cut_off_is_given_up_and_comes_back_and_the_result_is_the_same(cluster, undisturbed):
    job = cluster.submit()
    cluster.wait("tiles are done", lambda: (cluster.job(job)["progress"] or {}).get("tiles_done", 0) >= 2)
    cluster.network.cut("worker-1")
    cluster.wait("the scheduler gives it up", lambda: cluster.workers() == 1)
    cluster.network.mend("worker-1")
    cluster.wait("it is back", lambda: cluster.workers() == 2)
    cluster.wait("the basin is complete", lambda: cluster.succeeded(job))
    assert cluster.result(job) == undisturbed
    assert cluster.request("DELETE", f"/v1/jobs/{job}").status_code == 204


def test_a_scheduler_that_is_cut_off_is_found_again(cluster, undisturbed):
    job = cluster.submit()
    cluster.wait("tiles are done", lambda: (cluster.job(job)["progress"] or {}).get("tiles_done", 0) >= 2)
    cluster.network.cut("scheduler")
    time.sleep(5.0)
    cluster.network.mend("scheduler")
    cluster.wait("the basin is complete", lambda: cluster.succeeded(job))
    assert cluster.result(job) == undisturbed
    assert cluster.workers() == 2


def test_strangers_are_let_in_nowhere(cluster):
    url = f"http://{cluster.network.address('service')}:8000/v1/jobs"
    assert httpx.get(url, timeout=10).status_code == 401
    code = (
        "from distributed import Client\n"
        "try: Client('tcp://scheduler:8786', timeout=3)\n"
        "except Exception as error: print('refused')\n"
    )
    assert "refused" in cluster.once("worker-1", ["python", "-W", "ignore", "-c", code])
