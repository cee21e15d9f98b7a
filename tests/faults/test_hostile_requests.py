"""Twenty hostile requests at once: the service answers others meanwhile, keeps its memory, and stops when told to."""

import json
import os
import signal
import socket
import time
from concurrent.futures import ThreadPoolExecutor

import httpx2 as httpx
import psutil
import pytest

from tests.raw_http import connection, received

HARMONICS = [{"order": 969 + k, "amplitude": 1e-9} for k in range(32)]
FEW_HARMONICS = [{"order": 2 + k, "amplitude": 1e-9} for k in range(9)]
STIFF = {"model": "piecewise_linear", "eccentricity": 0.01}
SEEDS = {"seeds": [{"time": 0.553, "velocity": 4.703}], "kept": 1, "transient": 0}
MILLION = {"parameter": "damping", "start": 0.5, "stop": 0.6, "count": 1_000_000}
SMALL_CELLS = {"time": {"cells": 10}, "velocity": {"cells": 10}}
SQUARE = [
    {"parameter": "damping", "start": 0.5, "stop": 0.6, "count": 100},
    {"parameter": "stiffness", "start": 1e3, "stop": 1e4, "count": 100},
]
LARGE = {"grid": {"time": {"cells": 1200}, "velocity": {"cells": 1200}}, "iterations": 1}
POSTS = {
    "a million values": ("bifurcations", {"vary": MILLION, **SEEDS}),
    "a million values down": ("bifurcations", {"vary": MILLION | {"start": 0.6, "stop": 0.5}, **SEEDS, "kept": 2}),
    "a million geometric values": ("bifurcations", {"vary": MILLION | {"spacing": "geometric"}, **SEEDS}),
    "a million stiffnesses": (
        "bifurcations", {"oscillator": STIFF, "vary": MILLION | {"parameter": "stiffness", "start": 1e3, "stop": 1e4},
        **SEEDS},
    ),
    "a million values of many harmonics": (
        "bifurcations", {"oscillator": {"eccentricity": 0.01, "harmonics": HARMONICS}, "vary": MILLION, **SEEDS},
    ),
    "a hundred phases of many harmonics": (
        "bifurcations", {"oscillator": {"eccentricity": 0.01, "harmonics": HARMONICS},
        "vary": MILLION | {"parameter": "phase_970", "count": 100}, **SEEDS},
    ),
    "a square of many harmonics": (
        "sweeps", {"oscillator": STIFF | {"harmonics": HARMONICS}, "vary": SQUARE, "grid": SMALL_CELLS},
    ),
    "a square of some harmonics": (
        "sweeps", {"oscillator": STIFF | {"harmonics": FEW_HARMONICS}, "vary": SQUARE, "grid": SMALL_CELLS},
    ),
    "a check of a million values": ("checks", {"kind": "bifurcation", "vary": MILLION}),
    "a preview of many harmonics outside": ("previews", {"oscillator": {"eccentricity": 0.3, "harmonics": HARMONICS}}),
    "a motion of many harmonics outside": (
        "trajectories", {"oscillator": {"eccentricity": 0.3, "harmonics": HARMONICS}, "start": {"velocity": 3}},
    ),
    "a measured curve": (
        "basins", {"oscillator": {"transmission_error": {"angle": [n / 5000 for n in range(10_000)],
        "error": [n * 7919 % 1009 for n in range(10_000)]}}},
    ),
    "fifty thousand listed values": (
        "bifurcations", {"vary": {"parameter": "damping", "values": [0.5 + n * 1e-7 for n in range(50_000)]}, **SEEDS},
    ),
    "fifty thousand keys": ("basins", {f"k{n}": 1 for n in range(50_000)}),
    "wrong values": ("sweeps", {"vary": [{"parameter": "damping", "values": ["a"] * 200_000}]}),
    "a count of many digits": ("sweeps", {"vary": [MILLION | {"count": 10**3000}]}),
    "a range of many digits": ("sweeps", '{"vary": [{"parameter": "damping", "start": ' + "5" * 5000 + "}]}"),
    "deep lists": ("basins", "[" * 500_000),
    "deep objects": ("basins", '{"grid":' * 100_000),
    "half a character": ("sweeps", '{"vary": [{"parameter": "\\ud800", "values": [1]}]}'),
}  # fmt: skip
FEW = MILLION | {"count": 3}
ORDINARY = [
    ("bifurcations", {"vary": FEW, **SEEDS}),
    ("bifurcations", {"oscillator": {"eccentricity": 0.01, "harmonics": FEW_HARMONICS}, "vary": FEW, **SEEDS}),
    ("sweeps", {"oscillator": STIFF, "vary": [each | {"count": 2} for each in SQUARE], "grid": SMALL_CELLS}),
    ("checks", {"kind": "bifurcation", "vary": FEW}),
    ("previews", {"oscillator": {"eccentricity": 0.3, "harmonics": FEW_HARMONICS[:1]}}),
    ("previews", {}),
    ("trajectories", {"oscillator": {"eccentricity": 0.3, "harmonics": FEW_HARMONICS}, "start": {"velocity": 3}}),
    ("basins", {"oscillator": {"transmission_error": {"angle": [0, 0.25, 0.5, 0.75], "error": [0.01, 0, -0.01, 0]}}}),
]
"""One of each sort: what they load, a service has once, and not because of hostile ones."""
CHECK_BYTES = 100_000_000
"""A check of a million values: numbers of 24 bytes and their places in lists of 8, up to three times over."""
CHECKED_AT_ONCE = 3
"""Two at first, and one that takes longer. Were values kept, two times five requests would keep 32 MB each: more."""


def post(service, name):
    return name, answer_of(service, *POSTS[name])


def answer_of(service, path, body):
    content = body if isinstance(body, str) else json.dumps(body)
    headers = {"content-type": "application/json"}
    return httpx.post(f"{service.url}/v1/{path}", content=content, headers=headers, timeout=120)


def slow_body(port):
    """A body that comes byte by byte, for some seconds."""
    with connection(port) as line:
        line.sendall(b"POST /v1/basins HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n")
        line.sendall(b"content-length: 1000000\r\n\r\n")
        for _ in range(50):
            line.sendall(b"[")
            time.sleep(0.1)


def pipelined(port):
    """Requests that do not wait for answers."""
    for _ in range(20):
        with connection(port) as line:
            line.sendall(b"GET /v1/jobs HTTP/1.1\r\nhost: localhost\r\n\r\n" * 200)
            received(line)


def memory(service):
    return psutil.Process(service.process.pid).memory_info().rss


def test_hostile_requests_keep_nobody_waiting(a_service, health):
    with a_service(RATTLE_CONCURRENT_JOBS=1) as service:
        large = service.wait(service.submit(LARGE)["id"])
        assert large["state"] == "succeeded"
        table = f"/v1/jobs/{large['id']}/result.json?table=group"
        assert service.request("GET", table).status_code == 422
        assert all(answer_of(service, *each).is_success for each in ORDINARY)
        before, waits = memory(service), health(service)
        port = int(service.url.rpartition(":")[2])
        with ThreadPoolExecutor(len(POSTS) + 8) as threads:
            others = [threads.submit(slow_body, port), threads.submit(pipelined, port)]
            others += [threads.submit(service.request, "GET", table) for _ in range(4)]
            answers = list(threads.map(lambda name: post(service, name), POSTS))
            for other in others:
                other.result()
            answers += threads.map(lambda name: post(service, name), POSTS)
        grown = memory(service) - before
        listed = [service.request("GET", "/v1/jobs?size=200") for _ in range(4)]
        waited = waits()
        statuses = [(name, answer.status_code) for name, answer in answers]
        print(json.dumps({"longest ms": max(waited), "statuses": statuses, "bytes": grown}))
        assert {status for _, status in statuses} <= {200, 202, 400, 422, 429}, statuses
        assert all("retry-after" in answer.headers for _, answer in answers if answer.status_code == 429)
        assert all(len(page.content) < 8_000_000 for page in listed)
        accepted = dict(reversed(answers))["a million values"].json()  # of the first wave: the second may get 429
        assert accepted["request"]["vary"] == MILLION
        assert grown < CHECKED_AT_ONCE * CHECK_BYTES
        assert max(waited) < 150.0, sorted(waited)[-10:]


def test_a_job_of_a_million_values_is_cancelled_at_once(a_service):
    with a_service() as service:
        job = service.submit(POSTS["a million values"][1], "bifurcations")
        service.wait(job["id"], lambda job: job["state"] == "running")
        service.request("POST", job["links"]["cancel"])
        ended = service.wait(job["id"])
        assert ended["state"] == "cancelled"
        assert len(json.dumps(ended)) < 2000
        events = service.request("GET", job["links"]["events"]).content
        assert len(events) < 20_000


def test_the_service_stops_while_requests_are_checked(a_service):
    with a_service() as service, ThreadPoolExecutor(8) as threads:
        hostile = ["a square of some harmonics", "a hundred phases of many harmonics"] * 3
        asked = [threads.submit(post, service, name) for name in hostile]
        time.sleep(1.0)
        service.process.send_signal(signal.SIGTERM)
        service.process.wait(20)
        for each in asked:
            each.exception()
    assert os.path.getsize(service.data / "serve.log") < 1_000_000
    with pytest.raises(OSError):
        socket.create_connection(("127.0.0.1", int(service.url.rpartition(":")[2])), timeout=1)
