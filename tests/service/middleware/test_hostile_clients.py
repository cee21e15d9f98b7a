"""Clients that send huge or malformed requests cost a bounded part of the service, and others are answered meanwhile.

Slow clients are the proxy's task: `tests/hosts/test_hostile_clients.py`.
"""

import contextlib
import time
import tracemalloc
from http.client import HTTPResponse
from pathlib import Path

import pytest
from sqlalchemy import event

from service.records.job_record import JobState
from tests.raw_http import connection, received, sent_endlessly
from tests.service.idle_service import idle_service
from tests.service.records.many_jobs import add_copies
from tests.waiting import wait_until
from worker.jobs.basin_job import basin_job
from worker.stores.new_store import create_store


@pytest.fixture(scope="module")
def service(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        with idle_service(patch, tmp_path_factory.mktemp("idle"), max_connections=40) as service:
            yield service


def answers(service):
    return service.request("GET", "/healthz").status_code == 200


def test_connections_beyond_a_number_are_refused(service):
    with contextlib.ExitStack() as stack:
        for _ in range(40):
            stack.enter_context(connection(service.port))
        time.sleep(0.2)
        assert service.request("GET", "/healthz").status_code == 503
    time.sleep(0.2)
    assert answers(service)


@pytest.mark.parametrize(
    ("beginning", "part"),
    [
        (b"GET /", b"a" * 65536),
        (b"GET / HTTP/1.1\r\nx: ", b"a" * 65536),
        (b"GET / HTTP/1.1\r\n", b"x: a\r\n" * 10000),
        (b"POST /v1/basins HTTP/1.1\r\nhost: localhost\r\ntransfer-encoding: chunked\r\n\r\n", b"1\r\n{\r\n" * 10000),
        (
            b"POST /v1/basins HTTP/1.1\r\nhost: localhost\r\ntransfer-encoding: chunked\r\n\r\n0\r\n",
            b"x: a\r\n" * 10000,
        ),
        (b"", b"GET /healthz HTTP/1.1\r\nhost: localhost\r\n\r\n" * 10000),
    ],
    ids=["address", "header", "headers", "chunks", "trailers", "requests"],
)
def test_what_has_no_end_is_cut_off(service, beginning, part):
    with connection(service.port) as line:
        assert sent_endlessly(line, beginning, part) < 29_000_000
    assert answers(service)


def test_unfinished_bodies_hold_a_bounded_memory_and_keep_nobody_from_submitting(monkeypatch, tmp_path):
    most = 40_000
    head = (
        b"POST /v1/basins HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\ncontent-length: %d\r\n\r\n"
    )
    with idle_service(monkeypatch, tmp_path, max_body_bytes=most) as service, contextlib.ExitStack() as stack:
        held = service.app.state.bodies
        lines = [stack.enter_context(connection(service.port)) for _ in range(30)]
        for line in lines[:16]:
            line.sendall(head % most + b" " * (most - 1))
        wait_until("sixteen bodies lack their last byte", lambda: held.size == 16 * (most - 1))
        for line in lines[16:]:
            line.sendall(head % most + b" " * 20_000)
        refused = [received(line) for line in lines[16:]]
        assert all(each.startswith(b"HTTP/1.1 503") and b"\r\nretry-after: 1\r\n" in each for each in refused)
        assert held.size <= 16 * most
        small = service.request("POST", "/v1/basins", json={"iterations": 1})
        assert small.status_code == 202, small.text
        large = {"content": b'{"iterations": 1}' + b" " * 20_000, "headers": {"content-type": "application/json"}}
        assert service.request("POST", "/v1/basins", **large).status_code == 503
        for line in lines[:16]:
            line.close()
        wait_until("they are given up", lambda: held.size == 0)
        assert service.request("POST", "/v1/basins", **large).status_code == 202


def test_heads_of_many_requests_on_one_connection_are_not_added_up(service):
    asked = b"GET /healthz HTTP/1.1\r\nhost: localhost\r\nx: " + b"a" * 30_000 + b"\r\n\r\n"
    with connection(service.port) as line:
        for _ in range(9):
            line.sendall(asked)
            answer = HTTPResponse(line)
            answer.begin()
            assert answer.status == 200
            answer.read()


def test_endless_headers_cost_no_memory(service):
    tracemalloc.start()
    try:
        for _ in range(5):
            with connection(service.port) as line:
                sent_endlessly(line, b"GET / HTTP/1.1\r\n", b"x: a\r\n" * 10000)
        assert tracemalloc.get_traced_memory()[1] < 20_000_000
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    "raw",
    [
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"\0" * 40,
        b"GET\r\n\r\n",
        b"GET / HTTP/1.1\r\nhost: localhost\r\nno colon\r\n\r\n",
        b"GET / HTTP/1.1\r\nhost: localhost\r\nx: a\0b\r\n\r\n",
        b"GET \xff\xfe HTTP/1.1\r\nhost: localhost\r\n\r\n",
        b"CONNECT example.org:443 HTTP/1.1\r\nhost: localhost\r\n\r\n",
        b"POST / HTTP/1.1\r\nhost: localhost\r\ncontent-length: -1\r\n\r\n",
        b"POST / HTTP/1.1\r\nhost: localhost\r\ncontent-length: 1\r\ncontent-length: 2\r\n\r\nab",
        b"POST / HTTP/1.1\r\nhost: localhost\r\ncontent-length: 4\r\ntransfer-encoding: chunked\r\n\r\n0\r\n\r\n",
        b"POST / HTTP/1.1\r\nhost: localhost\r\ntransfer-encoding: chunked\r\n\r\nxyz\r\n",
        b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
    ],
    ids=["TLS", "no address", "header", "NUL", "bytes", "CONNECT", "length", "lengths", "smuggling", "chunk",
    "HTTP/2"],
)  # fmt: skip
def test_what_is_no_proper_http_is_refused_and_the_connection_ends(service, raw):
    with connection(service.port) as line:
        line.sendall(raw)
        assert received(line).startswith(b"HTTP/1.1 4")
    assert answers(service)


def test_pipelined_requests_are_answered_in_order(service):
    with connection(service.port) as line:
        paths = [b"/healthz", b"/nothing", b"/healthz"]
        asks = [b"GET %s HTTP/1.1\r\nhost: localhost\r\n" % path for path in paths]
        line.sendall(b"\r\n".join(asks) + b"connection: close\r\n\r\n")
        answer = received(line)
        assert [part[:3] for part in answer.split(b"HTTP/1.1 ")[1:]] == [b"200", b"404", b"200"]


@pytest.mark.parametrize(
    ("body", "status", "what"),
    [
        ('{"iterations": 1, "iterations": 7}', 422, "the key 'iterations' stands twice"),
        ('{"oscillator": {"damping": 0.6, "damping": 0.6}}', 422, "the key 'damping' stands twice"),
        ('{"vary": [{"parameter": "a"}, {"start": 0, "start": 1}]}', 422, "the key 'start' stands twice"),
        ('{"iterations": 1, "\\u0069terations": 7}', 422, "the key 'iterations' stands twice"),
        ("[" * 50_000 + "]" * 50_000, 400, "nested too deeply"),
        ('{"a":' * 50_000 + "1" + "}" * 50_000, 400, "nested too deeply"),
        ("[" * 900 + "]" * 900, 422, "send a JSON object"),
        ('{"grid":' * 500 + "1" + "}" * 500, 422, "Extra inputs are not permitted"),
        ('{"iterations": ' + "9" * 5000 + "}", 400, "error parsing the body"),
        ('{"iterations": 1e99999999}', 422, "iterations"),
        ('{"iter\ud800": 1}'.encode("utf-8", "surrogatepass"), 422, "body"),
        ('{"\\ud800": 1}', 422, "body"),
        ('{"\\ud800": 1, "\\ud800": 1}', 422, "stands twice"),
        (b"\xff\xfe", 400, "body"),
    ],
    ids=["key", "key within", "key in a list", "key escaped", "lists", "objects", "some lists", "some objects",
    "digits", "exponent", "surrogate", "surrogate escaped", "surrogates", "bytes"],
)  # fmt: skip
@pytest.mark.parametrize("path", ["/v1/basins", "/v1/sweeps", "/v1/trajectories"])
def test_json_that_is_not_plain_is_refused(service, path, body, status, what):
    answer = service.request("POST", path, content=body, headers={"content-type": "application/json"})
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json" and what in answer.json()["detail"]


NO_ID = ["nobody", "0" * 31, "0" * 33, "A" * 32, "0" * 31 + "g", "..%2f..%2fetc", "%00" * 32, "%2e%2e", "0" * 5000]


@pytest.mark.parametrize("job_id", NO_ID, ids=lambda text: text[:12])
def test_what_is_no_id_reaches_neither_database_nor_files(service, monkeypatch, job_id):
    monkeypatch.setattr(service.jobs, "get", lambda _: pytest.fail("asked for"))
    for method, path in (
        ("GET", ""), ("GET", "/result"), ("GET", "/picture.png"), ("GET", "/result.zarr/zarr.json"), ("GET", "/events"),
        ("POST", "/cancel"), ("DELETE", ""),
    ):  # fmt: skip
        answer = service.request(method, f"/v1/jobs/{job_id}{path}")
        assert answer.status_code == 404 and answer.headers["content-type"] == "application/problem+json"


def test_nothing_outside_a_store_is_served(service, tmp_path):
    job = service.add_job(7)
    location = f"{service.results}/{job.id}.zarr"
    create_store(location, basin_job(job.request))
    (tmp_path / "secret").write_text("what is in it")
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "secret").write_text("what is in it")
    Path(location, "link").symlink_to(tmp_path / "secret")
    Path(location, "folder").symlink_to(tmp_path / "folder")
    base = f"/v1/jobs/{job.id}/result.zarr"
    assert service.request("GET", f"{base}/zarr.json").status_code == 200
    climbing = ["..", "%2e%2e", "..%2f", "%2e%2e%2f", "..%5c", "....//", "%252e%252e", "group/..", "./", "%2f", "//"]
    for path in [f"{up}/jobs.sqlite" for up in climbing] + [
        "link", "folder/secret", "zarr.json%00", "zarr.json%00.png", "zarr%5c.json", "zarr.json/", "", "a" * 600,
        "C:%5cwindows", "%ff%fe", "zarr.json%0d%0ax: y", "~root", "con",
    ]:  # fmt: skip
        with connection(service.port) as line:
            line.sendall(f"GET {base}/{path} HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n".encode())
            answer = received(line)
        assert answer[9:12] in (b"404", b"400"), (path, answer[:200])
        assert b"what is in it" not in answer and b"SQLite" not in answer


def counted_steps(service, every):
    """One entry from now on for so many steps of SQLite's machine: a row looked at takes one at least."""
    steps = []

    def count(connection, *_):
        connection.set_progress_handler(lambda: steps.append(every), every)

    event.listen(service.jobs._sessions.kw["bind"], "checkout", count)
    return steps


def test_a_hundred_thousand_jobs_are_listed_by_pages_with_the_work_of_a_few(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path) as service:
        template = service.add_job()
        service.jobs.transition(template.id, JobState.QUEUED, JobState.SUCCEEDED)
        add_copies(service.app.state.settings.database, template.id, 100_000)
        service.request("GET", "/v1/jobs?size=200")
        tracemalloc.start()
        steps = counted_steps(service, 100)
        for path in ("?size=200", "?size=200&before=50000", "?size=200&before=201&state=succeeded", "?state=queued"):
            page = service.request("GET", f"/v1/jobs{path}").json()
            assert len(page["jobs"]) == (0 if "queued" in path else 200)
        assert sum(steps) < 100_000, "a page looks at every job"
        assert tracemalloc.get_traced_memory()[1] < 20_000_000
        tracemalloc.stop()
        assert 'rattle_jobs{state="succeeded"} 100001.0' in service.request("GET", "/metrics").text
