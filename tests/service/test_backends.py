"""The service on PostgreSQL and S3: what it answers is what it answers on SQLite and folders."""

import pytest
import xarray as xr

from tests.object_store import BUCKET, ObjectStore
from tests.running_service import running_service

pytestmark = pytest.mark.slow
GRID = {"time": {"cells": 160}, "velocity": {"cells": 160}}
BASIN = {"grid": GRID, "iterations": 1499}
SWEEP = {
    "grid": {"time": {"cells": 24}, "velocity": {"cells": 24}},
    "vary": [{"parameter": "damping", "values": [0.575, 0.6, 0.7]}],
    "iterations": 499,
}


@pytest.fixture(scope="module")
def remote(postgresql, object_store, tmp_path_factory):
    """A service that was killed in the middle of a basin and started again."""
    data = tmp_path_factory.mktemp("remote")
    places = {"RATTLE_DATABASE_URL": postgresql.new_database(), "RATTLE_STORE": f"s3://{BUCKET}/service"}
    with running_service(data, **places) as first:
        job = first.submit(BASIN)
        first.wait(job["id"], lambda job: job["progress"] and job["progress"]["tiles_done"] >= 2)
        first.kill()
    with running_service(data, **places) as second:
        yield second


def submitted(service, route, body):
    answer = service.request("POST", route, json=body)
    assert answer.status_code == 202, answer.text
    job = service.wait(answer.json()["id"])
    assert job["state"] == "succeeded", job["error"]
    return job


def result_without_times(service, job):
    result = service.request("GET", job["links"]["result"]).json()
    return {name: value for name, value in result.items() if name not in ("seconds", "links", "store", "zarr")}


@pytest.mark.timeout(240)
@pytest.mark.parametrize("route, body", [("/v1/basins", BASIN), ("/v1/sweeps", SWEEP)], ids=["basin", "sweep"])
def test_results_are_those_of_files_also_after_a_kill(service, remote, route, body):
    here, there = submitted(service, route, body), submitted(remote, route, body)
    assert result_without_times(remote, there) == result_without_times(service, here)
    with (
        xr.open_zarr(remote.url + there["links"]["zarr"]) as far,
        xr.open_zarr(service.url + here["links"]["zarr"]) as near,
    ):
        assert far.drop_attrs(deep=False).identical(near.drop_attrs(deep=False))
    pictures = [
        each.request("GET", job["links"]["picture"]).content for each, job in ((remote, there), (service, here))
    ]
    assert pictures[0] == pictures[1]
    assert there["created"].endswith("Z") and here["created"].endswith("Z")


@pytest.mark.timeout(240)
def test_parts_are_served_by_range_and_a_deleted_job_leaves_no_object(remote, object_store):
    job = submitted(remote, "/v1/basins", BASIN | {"iterations": 7})
    path = job["links"]["zarr"] + "/group/c/0/0"
    whole = remote.request("GET", path)
    for asked, part in (
        ("bytes=2-5", whole.content[2:6]),
        ("bytes=-3", whole.content[-3:]),
        ("bytes=4-", whole.content[4:]),
    ):
        answer = remote.request("GET", path, headers={"range": asked, "if-range": whole.headers["etag"]})
        assert answer.status_code == 206 and answer.content == part
    assert remote.request("GET", path, headers={"range": "bytes=1-2", "if-range": '"other"'}).status_code == 200
    beyond = remote.request("GET", path, headers={"range": "bytes=99999999-"})
    assert beyond.status_code == 416 and beyond.headers["content-range"] == f"bytes */{len(whole.content)}"
    assert int(remote.request("HEAD", path).headers["content-length"]) == len(whole.content)
    assert object_store.objects(f"service/{job['id']}.zarr")
    assert remote.request("DELETE", job["links"]["self"]).status_code == 204
    assert object_store.objects(f"service/{job['id']}.zarr") == {}


@pytest.mark.timeout(240)
def test_a_store_that_goes_away_fails_the_job_with_the_reason(postgresql, tmp_path):
    store = ObjectStore()
    store.start()
    places = {"RATTLE_DATABASE_URL": postgresql.new_database(), "RATTLE_STORE": f"s3://{BUCKET}/lost"}
    with running_service(tmp_path, **places, **store.variables) as service:
        job = service.submit({"grid": {"time": {"cells": 400}, "velocity": {"cells": 400}}, "iterations": 15013})
        service.wait(job["id"], lambda job: job["progress"] and job["progress"]["tiles_done"] >= 2)
        store.kill()
        job = service.wait(job["id"])
        assert job["state"] == "failed" and job["error"]["kind"] == "store-failed"
        assert "cannot be read or written" in job["error"]["detail"]
        answer = service.request("GET", job["links"]["result"])
        assert answer.status_code == 503 and answer.json()["type"] == "/problems/store-failed"
