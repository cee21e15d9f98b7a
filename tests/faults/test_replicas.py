"""Two replicas on one database and one folder of results: shared jobs, takeovers, and a replica that comes back."""

import contextlib
import itertools
import signal
import time

import pytest

from tests.faults.conftest import BASIN
from tests.faults.farm import begun
from tests.store_content import content
from tests.waiting import wait_until


@pytest.fixture
def replicas(a_service, tmp_path):
    """Start two; their databases and results are one."""
    shared = {"RATTLE_DATABASE_URL": f"sqlite:///{tmp_path / 'jobs.sqlite'}", "RATTLE_STORE": tmp_path / "results"}
    with contextlib.ExitStack() as stack:
        started = []
        for name in ("one", "two"):
            (tmp_path / name).mkdir()
            started.append(stack.enter_context(a_service(tmp_path / name, RATTLE_CONCURRENT_JOBS=1, **shared)))
        yield started


def owner(tmp_path, job):
    import sqlite3

    with contextlib.closing(sqlite3.connect(tmp_path / "jobs.sqlite")) as database:
        return database.execute("SELECT lease_owner FROM jobs WHERE id = ?", (job["id"],)).fetchone()[0]


def runs(replica, tmp_path, job):
    """Whether a replica has the lease of a job."""
    return str(replica.runner().pid) == (owner(tmp_path, job) or "..").split(".")[-2]


def runs_at(replicas, tmp_path, job):
    """The replica that runs a job, and the other one."""
    wait_until("a replica has the job", lambda: owner(tmp_path, job))
    here, there = sorted(replicas, key=lambda replica: not runs(replica, tmp_path, job))
    return here, there


def test_replicas_share_the_jobs_and_either_tells_of_all(replicas, tmp_path):
    primes = itertools.cycle((15013, 15017, 15031))
    jobs = [replicas[0].submit(BASIN | {"iterations": next(primes)}) for _ in range(2)]
    for job in jobs:
        replicas[1].wait(job["id"], lambda job: job["state"] == "running")
    assert owner(tmp_path, jobs[0]).split("/")[0] != owner(tmp_path, jobs[1]).split("/")[0]
    for job in jobs:
        answered = replicas[1].request("POST", f"/v1/jobs/{job['id']}/cancel")
        assert answered.json()["state"] in ("cancelling", "cancelled")
    for job in jobs:
        assert replicas[0].wait(job["id"])["state"] == "cancelled"


def lease_out(tmp_path, job, seconds):
    """Let the lease of a job run for so much longer."""
    import sqlite3

    with contextlib.closing(sqlite3.connect(tmp_path / "jobs.sqlite")) as database, database:
        database.execute("UPDATE jobs SET lease_until = lease_until + ? WHERE id = ?", (seconds, job["id"]))


def test_a_dead_replicas_job_is_taken_over_before_its_lease_runs_out(replicas, tmp_path, undisturbed):
    job = replicas[0].submit(BASIN)
    here, there = runs_at(replicas, tmp_path, job)
    begun(there, job)
    here.kill()
    lease_out(tmp_path, job, 3600.0)  # seen to be dead: nobody waits for its lease to run out
    wait_until("the other replica has the job", lambda: runs(there, tmp_path, job), there.why_not)
    assert there.wait(job["id"])["state"] == "succeeded"
    assert content(tmp_path / "results" / f"{job['id']}.zarr") == undisturbed["basin"].content


def test_a_paused_replica_loses_its_job_and_harms_nothing_when_it_wakes(replicas, tmp_path, undisturbed):
    job = replicas[0].submit(BASIN)
    here, there = runs_at(replicas, tmp_path, job)
    begun(there, job)
    here.signal(signal.SIGSTOP)
    begin = time.monotonic()
    wait_until("the other replica has the job", lambda: runs(there, tmp_path, job), there.why_not)
    assert time.monotonic() - begin > 10.0  # it might have come back: its lease was respected
    # It wakes while the other one writes, and again is asked for more when all is done.
    here.signal(signal.SIGCONT)
    assert there.wait(job["id"])["state"] == "succeeded"
    store = tmp_path / "results" / f"{job['id']}.zarr"
    assert content(store) == undisturbed["basin"].content
    time.sleep(3.0)
    assert content(store) == undisturbed["basin"].content
    assert here.request("GET", f"/v1/jobs/{job['id']}").json()["state"] == "succeeded"
    assert "taken over by another replica" in (here.data / "serve.log").read_text()


def test_a_cancelled_job_of_a_dead_replica_becomes_cancelled(replicas, tmp_path):
    job = replicas[0].submit(BASIN)
    here, there = runs_at(replicas, tmp_path, job)
    begun(there, job)
    here.signal(signal.SIGSTOP)
    assert there.request("POST", f"/v1/jobs/{job['id']}/cancel").json()["state"] == "cancelling"
    here.kill()
    assert there.wait(job["id"])["state"] == "cancelled"
