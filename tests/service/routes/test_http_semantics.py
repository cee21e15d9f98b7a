"""What HTTP promises of every address: HEAD beside GET, methods that are allowed, encodings by weight, ranges."""

import json
import re

import httpx2 as httpx
import pytest
from fastapi.routing import iter_route_contexts

from service.records.job_record import JobState
from tests.raw_http import connection, received
from tests.service.idle_service import idle_service
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.storage.location import result_location
from worker.stores.new_store import create_store


@pytest.fixture(scope="module")
def service(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        with idle_service(patch, tmp_path_factory.mktemp("idle")) as service:
            yield service


@pytest.fixture(scope="module")
def job(service):
    record = service.add_job(cells=4)
    create_store(result_location(service.results, record.id), BasinJob.from_request(record.request))
    return record


def test_head_is_answered_as_get_without_a_body(service, job):
    for path in ("/healthz", "/v1/jobs", f"/v1/jobs/{job.id}", f"/v1/jobs/{job.id}/result",
        f"/v1/jobs/{job.id}/result.zarr/zarr.json", "/openapi.json"):  # fmt: skip
        head, get = (service.request(method, path) for method in ("HEAD", "GET"))
        assert (head.status_code, head.content) == (200, b""), path
        assert head.headers.get("etag") == get.headers.get("etag")
        assert head.headers.get("content-length") == get.headers.get("content-length")
    assert service.request("HEAD", f"/v1/jobs/{'0' * 32}").status_code == 404
    assert service.request("HEAD", "/v1/basins").status_code == 405


def test_head_of_events_is_that_of_the_stream(service, job):
    path = f"/v1/jobs/{job.id}/events"
    head = service.request("HEAD", path)
    with httpx.stream("GET", service.url + path) as stream:
        own = {"date", "request-id", "transfer-encoding"}
        assert head.status_code == stream.status_code == 200 and head.content == b""
        assert {name: head.headers.get(name) for name in stream.headers.keys() - own} == {
            name: value for name, value in stream.headers.items() if name not in own
        }
    assert "content-length" not in head.headers
    assert service.request("HEAD", f"/v1/jobs/{'0' * 32}/events").status_code == 404
    ended = service.add_job(cells=5)
    service.jobs.transition(ended.id, JobState.QUEUED, JobState.CANCELLED)
    seen = {"last-event-id": str(service.app.state.events.newest([ended.id])[ended.id])}
    for method in ("HEAD", "GET"):
        assert service.request(method, f"/v1/jobs/{ended.id}/events", headers=seen).status_code == 204


def test_what_is_allowed_is_told_whole(service, job):
    by_path = {}
    for route in iter_route_contexts(service.app.routes):
        if getattr(route.original_route, "include_in_schema", False) and route.methods:
            by_path.setdefault(route.path, set()).update(route.methods)
    assert {"GET", "DELETE"} <= by_path["/v1/jobs/{job_id}"]
    for path, methods in by_path.items():
        address = re.sub(r"{path:path}", "zarr.json", path.replace("{job_id}", job.id))
        address = re.sub(r"{\w+}", "0", address)
        answer = service.request("PATCH", address)
        assert answer.status_code == 405, address
        allowed = methods | ({"HEAD"} if "GET" in methods else set())
        assert set(answer.headers["allow"].split(", ")) >= allowed, address


@pytest.mark.parametrize(
    ("accepted", "zipped"),
    [("gzip", True), ("gzip;q=0", False), ("br, gzip;q=0.000", False), ("*;q=0.1", True), ("*, gzip;q=0", False),
     ("identity", False), ("gzipped", False), ("GZIP;q=1.0", True)],
)  # fmt: skip
def test_gzip_is_used_where_its_weight_is_above_zero(service, accepted, zipped):
    answer = service.request("GET", "/openapi.json", headers={"accept-encoding": accepted})
    assert (answer.headers.get("content-encoding") == "gzip") is zipped


@pytest.mark.parametrize(
    ("asked", "status"),
    [
        (f"bytes={'9' * 5000}-", 416), (f"bytes=0-{'9' * 5000}", 206), (f"bytes=-{'9' * 5000}", 206),
        (f"bytes={'0' * 5000}-", 416), ("bytes=0-0", 206), ("bytes=²-", 200),
    ],
)  # fmt: skip
def test_a_range_of_thousands_of_digits_is_a_range(service, job, asked, status):
    path = f"/v1/jobs/{job.id}/result.zarr/zarr.json"
    answer = service.request("GET", path, headers={"range": asked.encode("latin-1")})
    assert answer.status_code == status
    whole = service.request("GET", path).content
    if status == 206:
        assert answer.content == (whole[:1] if asked == "bytes=0-0" else whole)


def test_the_sign_of_zero_makes_no_other_job(service):
    bodies = (
        {"oscillator": {"eccentricity": zero}, "grid": {"velocity": {"start": zero}, "time": {"start": zero}}}
        for zero in (0, 0.0, -0.0)
    )
    answers = [service.request("POST", "/v1/basins", content=json.dumps(body), headers=JSON).json() for body in bodies]
    assert len({answer["id"] for answer in answers}) == 1 and "-0" not in json.dumps(answers)
    sweeps = (SweepJob.from_request({"vary": [{"parameter": "eccentricity", "values": [z, 0.1]}]}) for z in (0.0, -0.0))
    assert len({sweep.digest for sweep in sweeps}) == 1


JSON = {"content-type": "application/json"}


@pytest.mark.parametrize("size", [65_300, 65_700, 70_000, 100_000])
@pytest.mark.parametrize("where", ["header", "address", "headers"])
def test_a_head_of_more_than_64_kib_is_refused(service, where, size):
    long = b"a" * size
    head = {
        "header": b"GET /healthz HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\nx: " + long + b"\r\n\r\n",
        "address": b"GET /" + long + b" HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n",
        "headers": b"GET /healthz HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n"
        + b"".join(b"x%d: %s\r\n" % (number, b"a" * 994) for number in range(size // 1000)) + b"\r\n",
    }[where]  # fmt: skip
    with connection(service.port) as line:
        line.sendall(head)
        refused = received(line).startswith(b"HTTP/1.1 400")
    assert refused == (len(head) > 65_536)


@pytest.mark.parametrize("path", [b"/healthz", b"/v1/jobs", b"/metrics", b"/explorer/js/main.js"])
def test_many_requests_at_once_end_without_a_traceback(service, caplog, path):
    for number in (66, 200, 1000):
        with connection(service.port) as line:
            line.sendall((b"GET " + path + b" HTTP/1.1\r\nhost: localhost\r\n\r\n") * number)
            assert received(line).count(b"HTTP/1.1 400") == 1
        with connection(service.port) as line:  # which goes without waiting for an answer
            line.sendall((b"GET " + path + b" HTTP/1.1\r\nhost: localhost\r\n\r\n") * 60)
    assert service.request("GET", "/readyz").status_code == 200
    assert not [record for record in caplog.records if record.exc_info]
