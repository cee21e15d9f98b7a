"""The scripts of docker/slurm under Slurm, on hosts of a network: a basin outlives its workers and its service."""

import contextlib
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

import rattle
from rattle_kernels import warm_up
from rattle_kernels.numerics.jit import cache_folder
from tests.hosts.network import Network
from tests.hosts.slurm import Slurm, environment_of_jobs
from tests.store_content import content
from worker.cluster.certificates import make_certificates

pytestmark = [pytest.mark.hosts, pytest.mark.timeout(1200)]

ROOT = Path(__file__).parents[2]
SCRIPTS = ROOT / "docker" / "slurm"
# Longer than a worker lives that has begun its last seconds.
CELLS, ITERATIONS = 1600, 2999
BASIN = {"grid": {"time": {"cells": CELLS}, "velocity": {"cells": CELLS}}, "iterations": ITERATIONS}
# Of the two cores that a node of these tests has; and the least time that Slurm can give and the script can use.
SERVICE = ["--nodelist=node1", "--cpus-per-task=1", "--mem=2G"]
WORKERS = ["--nodelist=node2", "--cpus-per-task=1", "--time=00:03:00", "--array=1-8%1"]


class Cluster:
    """The shared folder, Slurm, and the service that it runs."""

    def __init__(self, slurm, folder):
        self.slurm, self.folder = slurm, folder
        add_key = ["env", f"RATTLE_DATA={folder / 'data'}", folder / "venv/bin/rattle", "keys", "add", "tests"]
        self.key = slurm.call(*add_key).split()[-1]
        self.services = [slurm.submit(*SERVICE, SCRIPTS / "service.sbatch", folder) for _ in range(2)]
        self.workers = slurm.submit(
            *WORKERS, f"--dependency=after:{self.services[0]}", SCRIPTS / "workers.sbatch", folder
        )

    def request(self, method, path, body=None):
        """Answer of the service, asked on its own node, as through a tunnel."""
        command = ["curl", "--silent", "--show-error", "--fail-with-body", "--request", method]
        command += ["--header", f"authorization: Bearer {self.key}", "--header", "content-type: application/json"]
        command += ["--data", json.dumps(body)] if body else []
        answer = self.slurm.call(*command, f"http://127.0.0.1:8000{path}", host="node1")
        return json.loads(answer) if answer else None

    def wait(self, what, holds, seconds=300):
        """Wait until something holds."""
        patience = time.monotonic() + seconds
        while not (found := holds()):
            assert time.monotonic() < patience, f"still waiting until {what}: {self.logs()}"
            time.sleep(0.5)
        return found

    def ready(self):
        """Whether the service answers and has a worker."""
        with contextlib.suppress(AssertionError):
            return self.request("GET", "/readyz")["ready"]
        return False

    def task(self):
        """The array's task that runs."""
        return self.slurm.call("squeue", "--noheader", "--states", "running", "--format", "%i", "--jobs", self.workers)

    def job(self, job_id):
        """State of a job of the service."""
        job = self.request("GET", f"/v1/jobs/{job_id}")
        assert job["state"] not in ("failed", "cancelled"), (job["error"], self.logs())
        return job

    def tiles_done(self, job_id):
        """Tiles of a job that are done."""
        return (self.job(job_id)["progress"] or {}).get("tiles_done", 0)

    def result(self, job_id):
        """Content of a result, read from the shared folder."""
        self.wait("the basin is complete", lambda: self.job(job_id)["state"] == "succeeded")
        return content(self.folder / "data" / "results" / f"{job_id}.zarr")

    def logs(self):
        """Ends of all logs of Slurm's jobs."""
        logs = sorted((self.folder / "slurm").glob("*.log"))
        return "\n".join(f"== {log.name}\n{log.read_text(errors='replace')[-2000:]}" for log in logs)


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """What the same basin holds when it is computed on this machine alone."""
    store = tmp_path_factory.mktemp("local") / "basin.zarr"
    rattle.basin(cells=(CELLS, CELLS), iterations=ITERATIONS, store=store, progress=False)
    return content(store)


@pytest.fixture(scope="module")
def cluster(expected, tmp_path_factory):
    if os.geteuid() != 0:
        pytest.skip("network namespaces take root")
    warm_up()
    folder = tmp_path_factory.mktemp("shared")
    (folder / "slurm").mkdir()
    (folder / "venv").symlink_to(sys.prefix)
    make_certificates(folder / "certs", 1)
    shutil.copytree(cache_folder(), folder / "cache" / "gear-rattle" / cache_folder().name)
    with (
        Network(["head", "node1", "node2"], folder / "certs") as network,
        Slurm(network, "head", ["node1", "node2"], folder / "slurm", environment_of_jobs(ROOT)) as slurm,
    ):
        cluster = Cluster(slurm, folder)
        cluster.wait("the service has a worker", cluster.ready)
        yield cluster


def test_a_basin_outlives_its_worker_and_the_next_task_of_the_array_goes_on(cluster, expected):
    first = cluster.task()
    # So late that the worker's life ends in the middle: it leaves two minutes before the task's time is up.
    cluster.wait("the worker's last seconds have come", lambda: cluster.slurm.seconds_left(first) < 120 + 15)
    job = cluster.request("POST", "/v1/basins", BASIN)["id"]
    cluster.wait("tiles are done", lambda: cluster.tiles_done(job) >= 2)
    cluster.wait("the next task runs", lambda: cluster.task() not in ("", first))
    assert cluster.job(job)["state"] == "running"
    assert cluster.slurm.state(first) == "COMPLETED"
    assert cluster.result(job) == expected


def test_a_service_whose_time_is_up_is_followed_by_the_next_and_the_job_goes_on(cluster, expected):
    cluster.wait("there is a worker", cluster.ready)
    for old in cluster.request("GET", "/v1/jobs")["jobs"]:
        cluster.request("DELETE", f"/v1/jobs/{old['id']}")
    job = cluster.request("POST", "/v1/basins", BASIN)["id"]
    cluster.wait("tiles are done", lambda: cluster.tiles_done(job) >= 2)
    address = (cluster.folder / "scheduler").read_text()
    first, second = cluster.services
    assert cluster.slurm.state(second) == "PENDING"
    cluster.slurm.call("scancel", "--batch", "--signal=USR1", first)  # as Slurm does itself, a minute before the end
    cluster.wait("the second runs", lambda: cluster.slurm.state(second) == "RUNNING")
    assert cluster.slurm.state(first) == "COMPLETED"
    cluster.wait("it has a worker", cluster.ready)
    assert (cluster.folder / "scheduler").read_text() != address
    assert cluster.result(job) == expected


def test_workers_and_a_service_that_are_cancelled_put_things_in_order(cluster):
    cluster.wait("there is a worker", cluster.ready)
    for running, last in ((cluster.task(), "End worker"), (cluster.services[1], "End scheduler")):
        cluster.slurm.call("scancel", running)
        cluster.wait("it has ended", lambda job=running: cluster.slurm.state(job) == "CANCELLED")
        [log] = (cluster.folder / "slurm").glob(f"rattle-*-{running}.log")
        assert last in log.read_text()
    assert not (cluster.folder / "scheduler").exists()


@pytest.mark.parametrize("script", ["service.sbatch", "workers.sbatch"])
def test_a_script_without_its_folder_says_what_is_missing(script):
    answer = subprocess.run(["bash", SCRIPTS / script], capture_output=True, text=True)
    assert answer.returncode == 1 and f"sbatch {script} /shared/rattle" in answer.stderr
