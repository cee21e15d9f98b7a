"""Clients that are slow, huge or greedy, through the compose file's proxy: they hold the proxy, never the service."""

import contextlib
import os
import shutil
import ssl
import subprocess
import time
from pathlib import Path

import httpx2 as httpx
import psutil
import pytest
from fastapi import Response

from tests.ports import free_port
from tests.raw_http import ANY_CERTIFICATE, connection, received, sent_endlessly
from tests.service.idle_service import idle_service
from worker.cluster.certificates import make_certificates

pytestmark = pytest.mark.hosts

ROOT = Path(__file__).parents[2]
SECONDS = 3.0
NGINX = shutil.which("nginx", path=os.environ["PATH"] + ":/usr/sbin")


@pytest.fixture(scope="module")
def service(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        with idle_service(patch, tmp_path_factory.mktemp("idle"), max_connections=8) as service:
            yield service


@pytest.fixture(scope="module")
def proxy(service, tmp_path_factory):
    """Port of the proxy, as `docker/proxy/nginx.conf` has it but for addresses, files and shorter times."""
    folder, port = tmp_path_factory.mktemp("proxy"), free_port()
    certificates = make_certificates(folder / "certs", 1)
    text = (ROOT / "docker" / "proxy" / "nginx.conf").read_text()
    for old, new in (
        ("30s", f"{SECONDS:g}s"), ("limit_conn clients 100", "limit_conn clients 10"),
        ("listen 8443", f"listen 127.0.0.1:{port}"), ("/tmp/", f"{folder}/"),
        ("http://service:8000", service.url), ("/run/secrets/site_certificate", str(certificates.certificate)),
        ("/run/secrets/site_key", str(certificates.key)),
    ):  # fmt: skip
        assert old in text
        text = text.replace(old, new)
    (folder / "nginx.conf").write_text(text)
    (folder / "nginx").mkdir()
    command = [NGINX, "-p", str(folder), "-c", str(folder / "nginx.conf"), "-g", "daemon off; user root;"]
    process = subprocess.Popen(command)
    patience = time.monotonic() + 10
    while not any(each.laddr.port == port for each in psutil.net_connections("tcp") if each.status == "LISTEN"):
        assert process.poll() is None and time.monotonic() < patience
        time.sleep(0.05)
    yield port
    process.terminate()
    process.wait(10)


def answers(port):
    return httpx.get(f"https://127.0.0.1:{port}/healthz", verify=ANY_CERTIFICATE, timeout=10).status_code == 200


def connections_of(service):
    """Connections that the service holds."""
    own = psutil.Process().net_connections("tcp")
    return sum(each.status == "ESTABLISHED" and each.laddr.port == service.port for each in own)


BODY = b"POST /v1/basins HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n"
BEGINNINGS = {
    "nothing": b"",
    "a byte": b"G",
    "a head": b"GET /healthz HTTP/1.1\r\nhost: x\r\nx: " + b"a" * 100,
    "a body": BODY + b"content-length: 99\r\n\r\n{",
    "a chunk": BODY + b"transfer-encoding: chunked\r\n\r\n1\r\n{\r\n",
}


@pytest.mark.parametrize("beginning", BEGINNINGS.values(), ids=BEGINNINGS)
def test_a_request_that_does_not_end_is_ended_and_never_reaches_the_service(service, proxy, beginning):
    before = connections_of(service)
    with connection(proxy, tls=True) as line:
        begin = time.monotonic()
        line.sendall(beginning)
        assert connections_of(service) <= before
        assert b" 200 " not in received(line)
        assert time.monotonic() - begin < 5 * SECONDS


def test_a_head_that_drips_is_ended(proxy):
    with connection(proxy, tls=True) as line:
        begin = time.monotonic()
        line.sendall(b"GET / HTTP/1.1\r\nx: ")
        with contextlib.suppress(BrokenPipeError, ConnectionResetError, ssl.SSLError):
            while time.monotonic() - begin < 10 * SECONDS:
                line.sendall(b"x")
                time.sleep(0.1)
        assert time.monotonic() - begin < 5 * SECONDS


def test_many_slow_bodies_leave_the_service_to_others(service, proxy):
    """Each drips, so the proxy keeps it; the service, which takes 8 connections, sees none of them."""
    with contextlib.ExitStack() as stack:
        lines = [stack.enter_context(connection(proxy, tls=True)) for _ in range(9)]
        for part in (BODY + b"content-length: 99\r\n\r\n", b"{", b'"', b"a"):
            for line in lines:
                line.sendall(part)
            assert connections_of(service) <= 2
        assert answers(proxy)


def test_connections_of_one_client_are_bounded(proxy):
    ask = b"GET /healthz HTTP/1.1\r\nhost: localhost\r\ncontent-length: 9\r\n\r\n"
    with contextlib.ExitStack() as stack:
        lines = [stack.enter_context(connection(proxy, tls=True)) for _ in range(15)]
        for line in lines:
            line.sendall(ask)
        assert b" 503 " in received(lines[-1])
    time.sleep(0.2)
    assert answers(proxy)


@pytest.mark.parametrize(
    ("beginning", "part"),
    [
        (b"GET /", b"a" * 65536),
        (b"GET / HTTP/1.1\r\nx: ", b"a" * 65536),
        (b"GET / HTTP/1.1\r\n", b"x: a\r\n" * 10000),
        (BODY + b"transfer-encoding: chunked\r\n\r\n", b"ffff\r\n" + b"{" * 0xFFFF + b"\r\n"),
    ],
    ids=["address", "header", "headers", "chunks"],
)
def test_what_has_no_end_is_refused_and_never_reaches_the_service(service, proxy, beginning, part):
    before = connections_of(service)
    with connection(proxy, tls=True) as line:
        sent_endlessly(line, beginning, part, most=3_000_000)
        assert connections_of(service) <= before
        assert received(line).startswith(b"HTTP/1.1 4")
    assert answers(proxy)


def read_some(line, size):
    part = b""
    while len(part) < size and (more := line.recv(65536)):
        part += more
    return part


def read_until(line, text):
    answer = b""
    while text not in answer:
        more = line.recv(65536)
        assert more, f"the connection ended after {answer!r}"
        answer += more


def test_an_answer_that_is_not_read_leaves_the_service_at_once(service, proxy):
    """The proxy takes all of it, and gives it up after a while."""
    size = 30_000_000
    service.app.add_api_route("/v1/large", lambda: Response(b"x" * size))
    ask = b"GET /v1/large HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n"
    with connection(proxy, tls=True) as line:
        line.sendall(ask)
        time.sleep(2 * SECONDS)
        assert connections_of(service) == 0
        time.sleep(3 * SECONDS)
        assert len(received(line)) < size
    with connection(proxy, tls=True) as line:
        line.sendall(ask)
        got = 0
        for _ in range(10):  # slowly, but all the time
            time.sleep(SECONDS / 10)
            got += len(read_some(line, 1_000_000))
        assert got + len(received(line)) > size


def test_events_are_passed_on_as_they_happen(service, proxy):
    job = service.add_job()
    with connection(proxy, tls=True) as line:
        line.sendall(b"GET /v1/jobs/%s/events HTTP/1.1\r\nhost: localhost\r\n\r\n" % job.id.encode())
        read_until(line, b"event: state")
        service.jobs.request_cancel(job.id)
        read_until(line, b"cancelled")
