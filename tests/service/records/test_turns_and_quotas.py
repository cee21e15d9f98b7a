"""One who asks for much: others, and the small things of the same one, get their turn; too much is refused."""

import pytest

from tests.service.idle_service import idle_service
from tests.waiting import ended

SWEEP = {
    "grid": {"time": {"cells": 100}, "velocity": {"cells": 100}}, "iterations": 1499,
    "vary": [{"parameter": "damping", "start": 0.5, "stop": 0.7, "count": 1000}],
}  # fmt: skip


def small(cells):
    return {"grid": {"time": {"cells": cells}, "velocity": {"cells": cells}}, "iterations": 1}


@pytest.mark.slow
def test_a_small_basin_starts_behind_a_sweep_and_when_sweeps_take_all_they_can(service):
    sweeps = [service.submit(SWEEP)]
    service.wait(sweeps[0]["id"], lambda job: job["progress"] and job["progress"]["tiles_done"] >= 4)
    assert started_meanwhile(service, 30, sweeps)
    sweeps += [service.submit(SWEEP | {"iterations": k}) for k in (1511, 1523, 1531)]
    service.wait(sweeps[1]["id"], lambda job: job["progress"])
    assert started_meanwhile(service, 31, sweeps)
    for sweep in sweeps:
        assert service.request("POST", sweep["links"]["cancel"]).status_code == 202
    assert {service.wait(sweep["id"])["state"] for sweep in sweeps} == {"cancelled"}


def started_meanwhile(service, cells, sweeps):
    """Whether a small basin has started, and every sweep from before it has still to end."""
    service.wait(service.submit(small(cells))["id"], lambda job: job["state"] != "queued")
    return not any(ended(service.request("GET", sweep["links"]["self"]).json()) for sweep in sweeps)


@pytest.fixture
def visited(monkeypatch, tmp_path):
    """A service with room for three jobs, which runs none."""
    with idle_service(monkeypatch, tmp_path, max_queued_each=3) as service:
        yield service


def test_too_much_is_answered_by_429_with_the_limit_and_the_time_to_come_back(visited):
    for cells in (4, 5, 6):
        assert visited.request("POST", "/v1/basins", json=small(cells)).status_code == 202
    refused = visited.request("POST", "/v1/basins", json=small(7))
    assert refused.status_code == 429
    assert refused.headers["content-type"] == "application/problem+json"
    assert refused.json()["type"] == "/problems/too-much"
    assert "RATTLE_MAX_QUEUED_EACH" in refused.json()["detail"]
    assert 1 <= int(refused.headers["retry-after"]) <= 60
    # The same request as before is the same job: nothing more waits.
    assert visited.request("POST", "/v1/basins", json=small(4)).status_code == 202
