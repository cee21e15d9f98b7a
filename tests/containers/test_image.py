"""The image runs: no root, nothing to write to, no kernel compiled."""

import contextlib
import json
import time

import httpx2 as httpx
import pytest

from tests.analysis_requests import ROUTES as ANALYSES
from tests.ports import free_port

pytestmark = pytest.mark.containers


def get_when_there(url, seconds=300):
    patience = time.monotonic() + seconds
    while True:
        with contextlib.suppress(httpx.TransportError):
            return httpx.get(url, timeout=10)
        assert time.monotonic() < patience, f"nothing answers at {url}"
        time.sleep(0.5)


@pytest.fixture(scope="module")
def container(engine):
    """A service in a container, and its address."""
    port = free_port()
    engine.run("service", "--detach", "--env", f"RATTLE_PORT={port}", "gear-rattle")
    url = f"http://127.0.0.1:{port}"
    try:
        assert get_when_there(f"{url}/healthz").json()["status"] == "ok"
    except BaseException:
        print(engine.podman("logs", "service"))
        raise
    yield url
    engine.podman("rm", "--force", "service")


def compiled(engine):
    return engine.podman("exec", "service", "sh", "-c", "find /tmp/cache -name '*.nb?' | sort | xargs ls -l")


CELLS = {"time": {"cells": 60}, "velocity": {"cells": 60}}
STIFF = {"model": "piecewise_linear", "damping": 0.6, "eccentricity": 0.1, "half_backlash": 0.6, "stiffness": 1e4}
# So little damped that traps pay.
WEAK = {"damping": 0.05, "eccentricity": 0.005, "half_backlash": 0.6}
REQUESTS = [
    ("basins", {"grid": CELLS}),
    ("basins", {"grid": CELLS, "oscillator": STIFF}),
    ("basins", {"grid": CELLS, "oscillator": WEAK, "iterations": 4999}),
    ("sweeps", {"grid": CELLS, "vary": [{"parameter": "damping", "values": [0.5, 0.6]}]}),
    *ANALYSES.items(),
]


def test_the_service_in_it_computes_all_that_it_can_and_compiles_nothing(engine, container):
    before = compiled(engine)
    jobs = [httpx.post(f"{container}/v1/{route}", json=body, timeout=30).json() for route, body in REQUESTS]
    patience = time.monotonic() + 300
    for job in jobs:
        while (state := httpx.get(f"{container}/v1/jobs/{job['id']}", timeout=30).json()["state"]) != "succeeded":
            assert state in ("queued", "running") and time.monotonic() < patience
            time.sleep(0.2)
    result = httpx.get(f"{container}{jobs[0]['links']['result']}", timeout=30).json()
    assert {solution["name"] for solution in result["solutions"]} == {"permanent contact", "P(1,1,0)", "chaotic"}
    assert compiled(engine) == before and before.count(".nbc") > 30


def test_it_is_nobody_and_can_write_nowhere_but_to_its_data(engine, container):
    told = engine.podman(
        "exec",
        "service",
        "sh",
        "-c",
        "id -u; for at in / /opt/rattle /opt/cache /data; do touch $at/x && echo $at; done; true",
    )
    assert told.split() == ["10001", "/data"]
    assert "CapEff:\t0000000000000000" in engine.podman("exec", "service", "cat", "/proc/self/status")


def test_every_part_is_in_it(engine):
    for command in (["dask", "scheduler", "--version"], ["dask", "worker", "--version"], ["rattle", "--help"]):
        assert engine.run("part", "--rm", "gear-rattle", *command)


def test_it_is_healthy_by_its_own_check_and_keeps_no_tools(engine):
    described = json.loads(engine.podman("inspect", "--type", "image", "gear-rattle"))[0]
    assert described["Config"]["User"] == "10001" and "Healthcheck" in described
    assert described["Size"] < 1_000_000_000
    there = engine.run("tools", "--rm", "gear-rattle", "sh", "-c", "ls /opt/rattle/bin")
    assert not {"pip", "pytest", "mypy", "uv", "hatchling"} & set(there.split())
