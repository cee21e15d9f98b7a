"""A hundred requests a second, reads and submissions, for a minute, while tiles compute on both cores."""

import json
import os
import subprocess
import sys

import pytest

RATE, SECONDS = 100, int(os.environ.get("RATTLE_LOAD_SECONDS", "0"))
pytestmark = pytest.mark.skipif(SECONDS == 0, reason="needs a quiet machine of several cores: `make test-load`")
LONG = {"grid": {"time": {"cells": 3000}, "velocity": {"cells": 3000}}, "iterations": 10007}


def visited(service, job, previews):
    """What the second process says of its visit, with so many previews a second beside it."""
    port = service.url.rpartition(":")[2]
    command = [sys.executable, "-m", "tests.faults.visitors", port, job["id"], str(RATE), str(SECONDS), str(previews)]
    return json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


@pytest.mark.parametrize("previews", [0, 10])
def test_reads_stay_fast_and_nothing_fails_under_load(a_service, previews):
    with a_service() as service:
        job = service.submit(LONG)
        before = service.wait(job["id"], lambda job: job["progress"] and job["progress"]["tiles_done"] >= 2)
        report = visited(service, job, previews)
        after = service.request("GET", f"/v1/jobs/{job['id']}").json()
        tiles = after["progress"]["tiles_done"] - before["progress"]["tiles_done"]
        print(json.dumps(report | {"tiles": tiles}, indent=1))
        answers = [(status, count) for kind in report["kinds"].values() for status, count in kind["answers"].items()]
        assert max(int(status) for status, _ in answers) < 500
        assert sum(count for status, count in answers if status == "429") < 0.01 * RATE * SECONDS
        assert {status for status, _ in answers} <= {"200", "202", "429"}
        assert report["requests a second"] > 0.95 * RATE
        assert tiles >= 2
        assert report["kinds"]["status"]["milliseconds"]["99 %"] < 150.0
        service.request("POST", job["links"]["cancel"])
