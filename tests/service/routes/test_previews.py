"""Small basins over HTTP, answered at once."""

import base64
import contextlib
import re
import threading

import httpx2 as httpx
import numpy as np
import pytest

from tests.service.routes.problems import STIFF, assert_problem, left_behind
from worker.jobs.preview_request import PreviewRequest, preview_basin

# So stiff that each motion takes long to find.
SLOW = {"oscillator": {"model": "piecewise_linear", "stiffness": 1_000_000}, "iterations": 1499}
SMALL = {"grid": {"time": {"cells": 20}, "velocity": {"cells": 30}}, "iterations": 61}


def ask(service, **body):
    return service.request("POST", "/v1/previews", json=body)


def labels_of(answer):
    shape = answer["velocity"]["cells"], answer["time"]["cells"]
    return np.frombuffer(base64.b64decode(answer["labels"]), np.uint8).reshape(shape)


@pytest.mark.parametrize("oscillator", [{"damping": 0.575}, {"model": "piecewise_linear", "stiffness": 1000}])
def test_the_answer_is_the_preview_of_the_worker(service, oscillator):
    before = left_behind(service)
    answer = ask(service, oscillator=oscillator, **SMALL)
    assert answer.status_code == 200, answer.text
    told, own = answer.json(), preview_basin(PreviewRequest(oscillator=oscillator, **SMALL))
    np.testing.assert_array_equal(labels_of(told), own.solution)
    assert [each["name"] for each in told["solutions"]] == [each.name for each in own.attractors]
    assert [each["share"] for each in told["solutions"]] == own.shares.tolist()
    assert told["iterations"] == 61 and {"paper", "colour_blind"} == told["solutions"][0]["colours"].keys()
    assert left_behind(service) == before, "nothing is recorded"


def test_it_says_how_long_it_took_and_how_long_it_had_a_processor(service):
    timing = re.fullmatch(r"wall;dur=([\d.]+), cpu;dur=([\d.]+)", ask(service, **SMALL).headers["server-timing"])
    assert timing
    wall, processor = map(float, timing.groups())
    # Two clocks, each rounded to a tenth; the processor's counts in steps of up to 10 ms.
    assert 0.0 < processor <= wall + 10.2


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ({"grid": {"time": {"cells": 517}}}, "66176 cells are more than the limit of 65536"),
        ({"iterations": 10007}, "cells times iterations are more than the limit of 50000000"),
        ({"iterations": 100}, "nearest: 97 or 101"),
        ({"oscillator": STIFF | {"stiffness": 0.01}}, "contacts ring only above it"),
        ({"oscillator": {"half_backlash": 1e-300}}, "half_backlash must be at least 4 pi damping 2^-80"),
        ({"grid": {"velocity": {"stop": 1e6}}}, "speeds must be at most"),
        ({"sample": {"points": 10}}, "body.sample: Extra inputs"),
        ({"oscillator": {"model": "piecewise_linear"}}, "stiffness: Field required"),
    ],
)  # fmt: skip
def test_what_is_too_large_or_wrong_is_refused(service, body, told):
    assert_problem(ask(service, **body), 422, told)


def test_previews_whose_clients_are_gone_make_room(service):
    def hang_up():
        with contextlib.suppress(httpx.TimeoutException):
            httpx.post(f"{service.url}/v1/previews", json=SLOW, timeout=1.0)

    leaving = [threading.Thread(target=hang_up) for _ in range(6)]
    for each in leaving:
        each.start()
    assert service.request("GET", "/healthz").status_code == 200, "reads go on meanwhile"
    for each in leaving:
        each.join()
    # Each of the six would take the 20 s of the limit, two at a time.
    assert ask(service, **SMALL).status_code == 200


@pytest.mark.parametrize("path", ["/v1/previews", "/v1/checks", "/v1/basins"])
def test_iterations_that_no_one_can_make_are_refused_at_once(service, path):
    # Whether a number of twenty digits is a prime took hours of the process that answers.
    answer = service.request("POST", path, json={"iterations": 2**61})
    assert "iterations" in answer.text
    assert answer.status_code == (200 if path == "/v1/checks" else 422)
