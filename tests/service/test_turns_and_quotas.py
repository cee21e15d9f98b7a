"""One who asks for much: others, and the small things of the same one, get their turn; too much is refused."""

from datetime import datetime

import pytest
from fastapi.testclient import TestClient

from service.app import create_app
from service.database import open_database
from service.jobs import Jobs
from service.settings import Settings

SWEEP = {
    "grid": {"time": {"cells": 100}, "velocity": {"cells": 100}}, "iterations": 1499,
    "vary": [{"parameter": "damping", "start": 0.5, "stop": 0.7, "count": 1000}],
}  # fmt: skip


def small(cells):
    return {"grid": {"time": {"cells": cells}, "velocity": {"cells": cells}}, "iterations": 1}


def test_a_small_basin_behind_a_sweep_of_a_thousand_starts_within_two_seconds(service):
    sweep = service.submit(SWEEP)
    service.wait(sweep["id"], lambda job: job["progress"] and job["progress"]["tiles_done"] >= 4)
    basin = service.wait(service.submit(small(30))["id"], lambda job: job["state"] != "queued")
    waited = datetime.fromisoformat(basin["started"]) - datetime.fromisoformat(basin["created"])
    assert waited.total_seconds() < 2.0
    assert service.request("POST", sweep["links"]["cancel"]).status_code == 202
    assert service.wait(sweep["id"])["state"] == "cancelled"


class NoRunner:
    """Nothing runs, so that everything waits."""

    def ring(self):
        pass


@pytest.fixture
def visitor(tmp_path):
    """Client of a service with room for three jobs."""
    settings = Settings(data=tmp_path, max_queued_each=3)
    app = create_app(settings)
    engine, sessions = open_database(settings.database)
    app.state.jobs, app.state.runner = Jobs(sessions, settings.quotas), NoRunner()
    yield TestClient(app)
    engine.dispose()


def test_too_much_is_answered_by_429_with_the_limit_and_the_time_to_come_back(visitor):
    for cells in (4, 5, 6):
        assert visitor.post("/v1/basins", json=small(cells)).status_code == 202
    refused = visitor.post("/v1/basins", json=small(7))
    assert refused.status_code == 429
    assert refused.headers["content-type"] == "application/problem+json"
    assert refused.json()["type"] == "/problems/too-much"
    assert "RATTLE_MAX_QUEUED_EACH" in refused.json()["detail"]
    assert 1 <= int(refused.headers["retry-after"]) <= 60
    # The same request as before is the same job: nothing more waits.
    assert visitor.post("/v1/basins", json=small(4)).status_code == 202
