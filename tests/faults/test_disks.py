"""A full disk and one that cannot be written: the job fails with that reason, and goes on when there is room."""

import os
import subprocess

import pytest

from tests.faults.conftest import BASIN
from tests.faults.farm import store_of

pytestmark = pytest.mark.skipif(os.geteuid() != 0, reason="mounting a small disk needs root")


@pytest.fixture
def disk(tmp_path):
    """Mount, or mount anew, a small disk in memory; a function of mount options."""
    place = tmp_path / "results"
    place.mkdir()
    mounted = []

    def mount(options):
        again = ["-o", f"remount,{options}"] if mounted else ["-o", options]
        subprocess.run(["mount", "-t", "tmpfs", *again, "tmpfs", str(place)], check=True)
        mounted.append(options)

    yield mount
    subprocess.run(["umount", "--lazy", str(place)], check=bool(mounted))


def readable(service, job):
    """What the result of a job says of itself."""
    return service.request("GET", f"/v1/jobs/{job['id']}/result")


def test_a_full_disk_fails_the_job_with_that_reason_and_room_lets_it_go_on(a_service, disk, right, tmp_path):
    disk("size=500k")
    with a_service() as service:
        job = service.wait(service.submit(BASIN)["id"])
        assert job["state"] == "failed" and job["error"]["kind"] == "store-failed"
        assert "No space left on device" in job["error"]["detail"]
        result = readable(service, job).json()
        assert not result["complete"] and 0 < result["tiles_computed"] < result["tiles"]
        disk("size=100m")
        again = service.submit(BASIN)
        assert again["id"] != job["id"]
        assert service.wait(again["id"])["state"] == "succeeded"
        # What had been computed was not computed again: only tiles in flight, and those not yet in the ledger.
        right(store_of(service, job), "basin", 8)


def test_a_disk_too_full_to_begin_on_leaves_nothing_in_the_way(a_service, disk, right):
    disk("size=40k")
    with a_service() as service:
        job = service.wait(service.submit(BASIN)["id"])
        assert job["state"] == "failed" and "No space left on device" in job["error"]["detail"]
        assert readable(service, job).status_code == 404
        disk("size=100m")
        assert service.wait(service.submit(BASIN)["id"])["state"] == "succeeded"
        right(store_of(service, job), "basin", 0)


def test_a_disk_that_becomes_read_only_fails_the_job_with_that_reason(a_service, disk, right):
    disk("size=100m")
    with a_service() as service:
        job = service.submit(BASIN)
        service.wait(job["id"], lambda job: job["progress"] and job["progress"]["tiles_done"] >= 2)
        disk("ro")
        job = service.wait(job["id"])
        assert job["state"] == "failed" and job["error"]["kind"] == "store-failed"
        assert "Read-only file system" in job["error"]["detail"]
        disk("rw")
        assert service.wait(service.submit(BASIN)["id"])["state"] == "succeeded"
        right(store_of(service, job), "basin", 8)
