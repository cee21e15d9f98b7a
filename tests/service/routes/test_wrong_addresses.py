"""What is asked of a job of another kind, or with an unknown parameter, is refused in words; no path is shown."""

import pytest
import yaml

from service.openapi import as_yaml
from tests.service.idle_service import idle_service
from tests.service.routes.problems import assert_problem
from worker.errors import StoreFailed
from worker.jobs.basin_job import basin_job
from worker.jobs.orbits_job import OrbitsJob
from worker.storage.location import result_location
from worker.stores.new_store import create_store


@pytest.fixture
def service(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path) as service:
        yield service


@pytest.mark.parametrize(
    "address", ["outline", "overlays/grazing", "tiles/0", "shares.png", "shares.svg", "picture.png", "result"]
)
def test_a_job_of_another_kind_is_a_documented_conflict_that_shows_no_path(service, tmp_path, address):
    orbits, basin = service.jobs.submit(OrbitsJob(longest=1), "local")[0], service.add_job()
    # The store of a basin where that of orbits belongs: even then no folder is shown.
    create_store(result_location(service.results, orbits.id), basin_job(basin.request))
    answer = service.request("GET", f"/v1/jobs/{orbits.id}/{address}")
    assert answer.status_code == 409 and str(tmp_path) not in answer.text
    assert_problem(answer, 409, "" if address in ("picture.png", "result") else f"job {orbits.id} is of kind orbits")


def test_the_conflict_is_documented():
    paths = yaml.safe_load(as_yaml())["paths"]
    for address in ("outline", "overlays/{kind}", "tiles/{number}", "shares.png"):
        assert "409" in paths[f"/v1/jobs/{{job_id}}/{address}"]["get"]["responses"], address


def test_a_store_that_cannot_be_read_is_named_without_its_folder(service, tmp_path, monkeypatch):
    job = service.add_job()
    create_store(result_location(service.results, job.id), basin_job(job.request))

    def fail(*_):
        raise StoreFailed(f"the store {result_location(service.results, job.id)} cannot be read: no space left")

    monkeypatch.setattr("worker.results.summary.summarise", fail)
    answer = service.request("GET", f"/v1/jobs/{job.id}/result")
    assert str(tmp_path) not in answer.text
    assert_problem(answer, 503, f"the store {job.id}.zarr cannot be read: no space left")


@pytest.mark.parametrize(
    ("address", "known"),
    [
        ("/v1/jobs?kind=basin", "this address takes before, size, state"),
        ("/v1/jobs/{id}?size=3", "this address takes none"),
        (
            "/v1/jobs/{id}/picture.png?size=2000",
            "this address takes caption, colours, dpi, editable, font_size, height, layer, measure, note, overlay_key, "
            "overlays, palette, panel, width, window",
        ),
        ("/v1/jobs/{id}/tiles/0?spacing=2", "this address takes every, level"),
        ("/healthz?verbose=1", "this address takes none"),
        ("/v1/jobs/{id}/result.zarr/zarr.json?v=1", "this address takes none"),
    ],
)
def test_an_unknown_query_parameter_is_refused_with_the_known_ones(service, address, known):
    job = service.add_job()
    assert_problem(service.request("GET", address.format(id=job.id)), 422, known)


def test_known_query_parameters_are_taken(service):
    assert service.request("GET", "/v1/jobs?size=3&state=queued").status_code == 200


@pytest.mark.parametrize(
    ("path", "body"), [("basins", {}), ("sweeps", {"vary": [{"parameter": "damping", "values": [0.6]}]})]
)
def test_a_request_may_name_its_kind_as_every_answer_does(service, path, body):
    plain = service.request("POST", f"/v1/{path}", json=body).json()
    named = service.request("POST", f"/v1/{path}", json={"kind": plain["kind"]} | body)
    assert named.status_code == 202 and named.json()["id"] == plain["id"] and "kind" not in named.json()["request"]
    assert_problem(service.request("POST", f"/v1/{path}", json={"kind": "orbits"} | body), 422, "body.kind")
