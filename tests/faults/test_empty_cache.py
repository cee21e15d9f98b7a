"""A service none of whose kernels is compiled yet answers while it compiles them, and follows cancellations."""

import contextlib
import json

import psutil

from tests.raw_http import connection
from tests.waiting import wait_until

SMALL = {"grid": {"time": {"cells": 20}, "velocity": {"cells": 20}}, "iterations": 1}
# As long as the probe of Kubernetes waits by default.
_PROBE_MILLISECONDS = 1000.0


def compilers(service):
    """Processes in which the one that answers has kernels compiled."""
    found = set()
    for each in psutil.Process(service.process.pid).children():
        with contextlib.suppress(psutil.NoSuchProcess):
            if "rattle_kernels.numerics.compiled_apart" in each.cmdline():
                found.add(each.pid)
    return found


def test_an_empty_cache_of_kernels_keeps_nobody_waiting(a_service, health, tmp_path):
    with a_service(ready="/healthz", NUMBA_CACHE_DIR=tmp_path / "kernels") as service:
        waits = health(service)
        job = service.submit(SMALL)
        # Those that outlines need are compiled from the start.
        first = wait_until("kernels are compiled", lambda: compilers(service), service.why_not)
        body = json.dumps(SMALL | {"iterations": 7}).encode()
        head = (
            b"POST /v1/previews HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\ncontent-length: %d\r\n"
        )
        with connection(int(service.url.rpartition(":")[2])) as line:
            line.sendall(head % len(body) + b"\r\n" + body)
            wait_until("the preview's kernels are compiled", lambda: compilers(service) - first, service.why_not)
        # Its client is gone.
        wait_until("they are given up", lambda: not compilers(service) - first, service.why_not)
        assert service.request("POST", job["links"]["cancel"]).status_code == 202
        assert service.wait(job["id"])["state"] == "cancelled"
        waited = waits()
        print(json.dumps({"longest ms": max(waited), "asked": len(waited)}))
        assert max(waited) < _PROBE_MILLISECONDS, sorted(waited)[-10:]
