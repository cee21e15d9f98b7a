"""A basin over HTTP, as a client sees it."""

import io
import itertools
import json
import signal
from importlib.metadata import version

import numpy as np
import pytest
import xarray as xr
from PIL import Image

from tests.running_service import running_service
from tests.service.routes.problems import assert_problem
from worker.results.opening import open_basin
from worker.stores.opening import holds_store

_iterations = itertools.count()
# Distinct requests from a list of primes, so that tests do not answer each other's.
_PRIMES = (101, 103, 107, 109, 113, 127, 131, 137, 139, 149, 151, 157, 163, 167, 173)


def request(cells=60, **changes):
    grid = {"time": {"cells": cells}, "velocity": {"cells": cells}}
    return {"grid": grid, "iterations": _PRIMES[next(_iterations)]} | changes


LONG = {"grid": {"time": {"cells": 2000}, "velocity": {"cells": 2000}}, "iterations": 1499}


@pytest.fixture(scope="module")
def finished(service):
    # After as many applications every quiet cell is captured: after 101, one is still on its way.
    job = service.submit(request(cells=120, iterations=499))
    return service.wait(job["id"])


def test_a_submission_is_accepted_with_its_place_and_the_papers_defaults(service):
    answer = service.request("POST", "/v1/basins", json=request(cells=10))
    job = answer.json()
    assert answer.status_code == 202
    assert answer.headers["location"] == f"/v1/jobs/{job['id']}" == job["links"]["self"]
    assert job["request"]["oscillator"] == {
        "model": "impacting", "damping": 0.6, "eccentricity": 0.1, "half_backlash": 0.6,
    }  # fmt: skip
    assert job["request"]["grid"]["velocity"] == {"start": 0.0, "stop": 7.0, "cells": 10}
    assert service.wait(job["id"])["state"] == "succeeded"


def test_the_same_request_is_the_same_job(service):
    body = request(cells=20)
    first = service.submit(body)
    written_otherwise = body | {"oscillator": {"damping": 0.6, "half_backlash": 6e-1}}
    assert service.submit(written_otherwise)["id"] == first["id"]
    service.wait(first["id"])
    assert service.submit(body)["id"] == first["id"]


def test_a_finished_job_has_progress_and_times(finished):
    assert finished["state"] == "succeeded" and finished["error"] is None
    assert finished["created"] <= finished["started"] <= finished["finished"]
    assert finished["progress"]["stage"] == "done"
    assert finished["progress"]["tiles_done"] == finished["progress"]["tiles_total"] > 0
    assert finished["progress"]["cells_done"] == 120 * 120


def test_the_result_names_solutions_with_shares_and_points(service, finished):
    result = service.request("GET", finished["links"]["result"]).json()
    solutions = {solution["name"]: solution for solution in result["solutions"]}
    assert result["complete"] and solutions.keys() == {"permanent contact", "P(1,1,0)", "chaotic"}
    assert sum(solution["share"] for solution in solutions.values()) == pytest.approx(1.0)
    captured = round(solutions["permanent contact"]["share"] * 120 * 120)
    assert result["image_counts"] == {"sink": 0, "permanent_contact": captured, "undecided": 0}
    assert solutions["P(1,1,0)"]["points"][0][1] == pytest.approx(1.2 * np.pi, abs=1e-10)
    assert solutions["permanent contact"]["lyapunov_exponent"] is None
    assert len(solutions["chaotic"]["points"]) == 100


def test_the_store_opens_over_http_as_from_its_path(service, finished):
    url = service.url + finished["links"]["zarr"]
    with open_basin(url) as remote, open_basin(service.store_of(finished)) as local:
        assert remote.solution.dims == ("velocity", "time")
        xr.testing.assert_identical(remote.load(), local.load())


def test_parts_of_the_store_are_served_by_range_and_head(service, finished):
    path = finished["links"]["zarr"] + "/group/c/0/0"
    whole = service.request("GET", path).content
    part = service.request("GET", path, headers={"range": "bytes=2-5"})
    head = service.request("HEAD", path)
    assert part.status_code == 206 and part.content == whole[2:6]
    assert head.status_code == 200 and int(head.headers["content-length"]) == len(whole)


@pytest.mark.parametrize("layer", ["solution", "group", "period", "step", "loudness"])
def test_every_layer_has_a_picture(service, finished, layer):
    answer = service.request("GET", f"{finished['links']['picture']}?layer={layer}")
    assert answer.headers["content-type"] == "image/png" and answer.content.startswith(b"\x89PNG")


def test_a_picture_can_be_that_of_what_is_seen(service, finished):
    picture = finished["links"]["picture"]
    seen = "window=0.75,1.25,2,5&overlays=&palette=colour_blind&panel=0"
    answers = {query: service.request("GET", f"{picture}?{query}") for query in ("", seen, seen.replace("=2", "=3"))}
    assert all(answer.content.startswith(b"\x89PNG") for answer in answers.values())
    assert len({answer.content for answer in answers.values()}) == len(
        {each.headers["etag"] for each in answers.values()}
    )
    assert service.request("GET", f"{picture.replace('png', 'svg')}?{seen}").content.startswith(b"<?xml")


@pytest.mark.parametrize(
    ("query", "told"),
    [
        ("window=0.2,0.6", "a window is four numbers"),
        ("window=0.2,0.6,90,95", "the job covers t 0 to 1"),
        ("panel=3", "there is no basin 3"),
        ("panel=-1", "query.panel"),
        ("overlays=clouds", "there is no overlay 'clouds'"),
        ("palette=grey", "query.palette"),
        ("width=2000", "query.width"),
        ("dpi=5000", "query.dpi"),
        ("font_size=0", "query.font_size"),
        ("width=1200&height=1200&dpi=1200", "at most 40 million pixels"),
        ("note=here", "a note is a time, a speed and a label"),
        ("colours=P(1,1,0):blue", "a motion's colour is written as"),
    ],
)
def test_what_cannot_be_seen_is_refused_in_words(service, finished, query, told):
    assert_problem(service.request("GET", f"{finished['links']['picture']}?{query}"), 422, told)


def test_a_picture_for_a_paper_has_its_size_its_text_and_a_caption(service, finished):
    picture = finished["links"]["picture"]
    how = "width=86&dpi=300&font_size=7&editable=true&overlay_key=true&caption=true"
    drawn = {each: service.request("GET", f"{picture.replace('png', each)}?{how}") for each in ("png", "svg", "pdf")}
    assert Image.open(io.BytesIO(drawn["png"].content)).width == pytest.approx(1016, abs=1)
    text = drawn["svg"].text
    for words in ("departures of", "grazing curve", "120 x 120 cells, k = 499", "doi:10.1142/S021812740902283X"):
        assert words in text
    assert b"/Subject" in drawn["pdf"].content
    assert (
        len({answer.headers["etag"] for answer in drawn.values()} | {service.request("GET", picture).headers["etag"]})
        == 4
    )


def test_a_result_is_there_as_netcdf(service, finished, tmp_path):
    address = f"{finished['links']['result']}.nc"
    answer = service.request("GET", address)
    (tmp_path / "result.nc").write_bytes(answer.content)
    with xr.open_dataset(tmp_path / "result.nc") as read:
        assert json.loads(read.attrs["request"]) == finished["request"]
        assert read.solution.shape == (read.sizes["velocity"], read.sizes["time"])
    assert service.request("GET", address, headers={"if-none-match": answer.headers["etag"]}).status_code == 304


def test_a_picture_and_a_result_that_have_not_changed_are_not_sent_again(service, finished):
    picture, result = finished["links"]["picture"], finished["links"]["result"]
    etags = [service.request("GET", path).headers["etag"] for path in (picture, f"{picture}?layer=step", result)]
    assert len(set(etags)) == 3
    for path, etag in zip((picture, f"{picture}?layer=step", result), etags, strict=True):
        again = service.request("GET", path, headers={"if-none-match": etag})
        assert again.status_code == 304 and again.content == b""
    assert service.request("GET", picture, headers={"if-none-match": etags[1]}).status_code == 200


def test_events_of_a_job_tell_its_stages_and_its_end(service):
    job = service.submit(request(cells=100))
    told = service.request("GET", job["links"]["events"]).text
    assert [line for line in told.splitlines() if line.startswith("event: ")][-1] == "event: state"
    assert '"state":"running"' in told and '"state":"succeeded"' in told


def test_a_running_job_shows_what_it_has_and_stops_when_cancelled(service):
    job = service.submit(LONG)
    job = service.wait(job["id"], lambda job: job["progress"] and job["progress"]["tiles_done"] >= 2)
    result = service.request("GET", job["links"]["result"]).json()
    assert not result["complete"] and 0 < result["tiles_computed"] < result["tiles"]
    picture = service.request("GET", job["links"]["picture"])
    assert picture.content.startswith(b"\x89PNG")
    known = {"if-none-match": picture.headers["etag"]}
    answers = (service.request("GET", job["links"]["picture"], headers=known) for _ in itertools.count())
    changed = next(answer for answer in answers if answer.status_code != 304)  # as soon as there are more tiles
    assert changed.status_code == 200 and changed.headers["etag"] != picture.headers["etag"]
    with xr.open_zarr(service.url + job["links"]["zarr"]) as basin:
        assert basin.attrs["complete"] is False
        there = np.argwhere(basin.tile_state.values >= 2)[0]
        rows, columns = (there * basin.attrs["tile_cells"]).tolist()
        assert int(basin.image_cell[rows, columns]) >= -2
        assert int(basin.solution[rows, columns]) == -9
    assert service.request("POST", job["links"]["cancel"]).json()["state"] in ("cancelling", "cancelled")
    assert service.wait(job["id"])["state"] == "cancelled"
    assert service.wait(service.submit(request(cells=10))["id"])["state"] == "succeeded", "workers are free again"
    again = service.submit(LONG)
    assert again["id"] != job["id"]
    assert service.request("DELETE", f"/v1/jobs/{again['id']}").status_code == 204


def test_a_deleted_job_leaves_nothing(service):
    job = service.wait(service.submit(request(cells=10))["id"])
    assert holds_store(service.store_of(job))
    assert service.request("DELETE", job["links"]["self"]).status_code == 204
    assert not holds_store(service.store_of(job))
    assert service.request("GET", job["links"]["self"]).status_code == 404
    assert service.request("DELETE", job["links"]["self"]).status_code == 404


def test_the_list_is_walked_page_by_page_newest_first(service, finished):
    for _ in range(2):
        service.wait(service.submit(request(cells=10))["id"])
    path, seen = "/v1/jobs?size=2", []
    while path:
        page = service.request("GET", path).json()
        assert len(page["jobs"]) <= 2
        seen += [job["id"] for job in page["jobs"]]
        path = page["next"]
    everything = [job["id"] for job in service.request("GET", "/v1/jobs?size=200").json()["jobs"]]
    assert seen == everything and finished["id"] in seen
    created = [job["created"] for job in service.request("GET", "/v1/jobs?size=200").json()["jobs"]]
    assert created == sorted(created, reverse=True)
    only = service.request("GET", "/v1/jobs?state=cancelled").json()["jobs"]
    assert all(job["state"] == "cancelled" for job in only)


@pytest.mark.slow
@pytest.mark.timeout(240)
def test_a_stopped_service_resumes_its_job_at_the_next_start(tmp_path):
    body = {"grid": {"time": {"cells": 500}, "velocity": {"cells": 500}}, "iterations": 1499}
    with running_service(tmp_path) as first:
        job = first.submit(body)
        first.wait(job["id"], lambda job: job["progress"] and job["progress"]["tiles_done"] >= 2)
        first.process.send_signal(signal.SIGTERM)
        assert first.process.wait(30) == 0
    with running_service(tmp_path) as second:
        done = second.wait(job["id"])
        assert done["state"] == "succeeded"
        assert second.submit(body)["id"] == job["id"]
    assert "Traceback" not in (tmp_path / "serve.log").read_text()


@pytest.mark.slow
@pytest.mark.timeout(240)
def test_a_killed_service_resumes_its_job_at_the_next_start(tmp_path):
    body = {"grid": {"time": {"cells": 300}, "velocity": {"cells": 300}}, "iterations": 1499}
    with running_service(tmp_path) as first:
        job = first.submit(body)
        first.wait(job["id"], lambda job: job["progress"] and job["progress"]["tiles_done"] >= 2)
        first.kill()
    with running_service(tmp_path) as second:
        assert second.wait(job["id"])["state"] == "succeeded"


def test_health_tells_what_is_there(service):
    assert service.request("GET", "/healthz").json() == {"status": "ok", "version": version("gear-rattle")}
    assert service.request("GET", "/readyz").json() == {"ready": True, "database": True, "workers": 2}


@pytest.mark.proof
@pytest.mark.timeout(400)  # the first proof compiles its kernels
def test_a_proof_is_asked_for_and_its_certificate_read(service):
    """The map of what is proven is tested elsewhere: here are its doors."""
    job = service.submit(request(cells=8, prove={"levels": 0}))
    assert job["request"]["prove"] == {"levels": 0, "tolerances": {}}
    assert service.wait(job["id"])["state"] == "succeeded"
    certificate = service.request("GET", f"/v1/jobs/{job['id']}/certificate.json").json()
    assert certificate["machine"]["damping"] == [0.6, 0.6] and certificate["counts"]["cells"] == 64
    solutions = service.request("GET", f"/v1/jobs/{job['id']}/result").json()["solutions"]
    assert [each["share_proven"] for each in solutions] == certificate["shares"]
    assert sum(certificate["shares"]) > 0.1
    bounds = [[each["share_proven"], each["share_at_most"]] for each in solutions]
    assert all(least <= each["share"] <= most for each, (least, most) in zip(solutions, bounds, strict=True))
    assert service.request("GET", f"/v1/jobs/{job['id']}/outline").json()["share_bounds"] == bounds


def test_a_job_without_a_proof_has_no_certificate(service, finished):
    answer = service.request("GET", f"/v1/jobs/{finished['id']}/certificate.json")
    assert_problem(answer, 404, "no proof was asked for")
    solutions = service.request("GET", f"/v1/jobs/{finished['id']}/result").json()["solutions"]
    assert all("share_proven" not in each and "share_at_most" not in each for each in solutions)


@pytest.mark.parametrize(
    ("prove", "place", "told"),
    [
        ({"levels": 7}, ["body", "prove", "levels"], "less than or equal to 3"),
        ({"tolerances": {"mass": [1, 2]}}, ["body", "prove", "tolerances", "mass"], "mass has no tolerance"),
    ],
)
def test_a_proof_that_cannot_be_had_is_refused_by_field(service, prove, place, told):
    answer = service.request("POST", "/v1/basins", json=request(cells=8, prove=prove))
    assert_problem(answer, 422, told)
    assert answer.json()["errors"][0]["location"] == place
