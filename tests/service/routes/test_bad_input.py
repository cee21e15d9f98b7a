"""Whatever is wrong with a request, a 4xx problem document says what would be right, and nothing is left behind."""

import itertools

import pytest

from tests.service.routes.problems import STIFF, assert_problem, left_behind

REFUSED = [
    ({"colour": 1}, 422, "body.colour: Extra inputs are not permitted"),
    ({"iteration": 3}, 422, "body.iteration: Extra inputs are not permitted; did you mean iterations?"),
    ({"impacting": 1}, 422, "body.impacting: Extra inputs are not permitted"),
    ({"oscillator": {"piecewise_linear": 1}}, 422, "body.oscillator.piecewise_linear: Extra inputs are not permitted"),
    ({"oscillator": {"dampning": 0.6}}, 422, "dampning: Extra inputs are not permitted; did you mean damping?"),
    ({"oscillator": {"dampnig": 0.5}}, 422, "dampnig"),
    ({"oscillator": {"damping": "much"}}, 422, "body.oscillator.damping: Input should be a valid number"),
    ({"oscillator": {"damping": True}}, 422, "valid number"),
    ({"oscillator": {"damping": None}}, 422, "valid number"),
    ({"oscillator": {"damping": 0}}, 422, "greater than 0"),
    ({"oscillator": {"half_backlash": -1}}, 422, "greater than 0"),
    ({"oscillator": STIFF | {"stiffness": 0.01}}, 422, "contacts ring only above it"),
    ({"oscillator": {"model": "elastic"}}, 422, "whose model is 'impacting' (the default) or 'piecewise_linear'"),
    ({"oscillator": {"model": 3}}, 422, "whose model is"),
    ({"oscillator": {"model": "piecewise_linear"}}, 422, "body.oscillator.stiffness: Field required"),
    (
        {"oscillator": {"model": "piecewise_linear", "stiffness": 100, "eccentricity": 0.16}},
        422,
        "epsilon_crit1 = 0.15263",
    ),
    ({"oscillator": {"model": "piecewise_linear", "stiffness": 0}}, 422, "body.oscillator.stiffness"),
    ({"oscillator": {"model": "piecewise_linear", "stiffness": -5}}, 422, "body.oscillator.stiffness"),
    ({"oscillator": {"model": "piecewise_linear", "stiffness": 0.01}}, 422, "stiffness must be above damping^2/8"),
    ({"oscillator": {"stiffness": 100}}, 422, "stiffness belongs to the piecewise linear model"),
    ({"oscillator": {"permanent_contact": "envelope"}}, 422, "permanent_contact belongs to the piecewise linear"),
    ({"oscillator": [0.6, 0.1, 0.6]}, 422, "body.oscillator: send an object"),
    ({"iterations": 1500}, 422, "nearest: 1499 or 1511"),
    ({"iterations": 0}, 422, "greater than or equal to 1"),
    ({"iterations": 1.5}, 422, "valid integer"),
    ({"iterations": 10**40}, 422, "limit of 10000019"),
    ({"grid": {"time": {"cells": 0}}}, 422, "greater than or equal to 1"),
    ({"grid": {"time": {"cells": 10**6}, "velocity": {"cells": 10**6}}}, 422, "limit of 25000000"),
    (
        {"grid": {"time": {"cells": 5000}, "velocity": {"cells": 5000}}, "iterations": 100003},
        422,
        "cells times iterations",
    ),
    ({"grid": {"velocity": {"start": 5, "stop": 2}}}, 422, "body.grid.velocity: stop must be above start = 5"),
    ({"grid": {"time": {"start": 0.7, "stop": 0.2}}}, 422, "body.grid.time: stop must be above start = 0.7"),
    ({"grid": {"time": {"start": 0.5, "stop": 1.9}}}, 422, "at most one period"),
    ({"grid": {"velocity": {"start": -1}}}, 422, "greater than or equal to 0"),
]
RAW = [
    ('{"oscillator": {"damping": NaN}}', 422, "finite number"),
    ('{"oscillator": {"damping": Infinity}}', 422, "finite number"),
    ('{"oscillator": {"damping": 1e400}}', 422, "finite number"),
    ('{"grid": {"velocity": {"stop": -Infinity}}}', 422, "finite number"),
    ('{"iterations": NaN}', 422, "body.iterations"),
    ("{", 400, "not valid JSON at character 1"),
    ("", 422, "body"),
    ("[]", 422, "send a JSON object"),
    ('"basin"', 422, "send a JSON object"),
    ('{"oscillator": "\\ud800"}', 422, "body.oscillator"),
    ("[" * 100_000, 400, "nested too deeply"),
]


@pytest.mark.parametrize(("request_", "status", "told"), REFUSED, ids=lambda part: str(part)[:50])
def test_a_wrong_request_is_refused(service, request_, status, told):
    before = left_behind(service)
    assert_problem(service.request("POST", "/v1/basins", json=request_), status, told)
    assert left_behind(service) == before


@pytest.mark.parametrize(("raw", "status", "told"), RAW, ids=[raw[:40] or "nothing" for raw, _, _ in RAW])
def test_what_json_cannot_or_should_not_carry_is_refused(service, raw, status, told):
    before = left_behind(service)
    headers = {"content-type": "application/json"}
    assert_problem(service.request("POST", "/v1/basins", content=raw, headers=headers), status, told)
    assert left_behind(service) == before


def test_another_content_type_is_refused(service):
    headers = {"content-type": "text/plain"}
    answer = service.request("POST", "/v1/basins", content="{}", headers=headers)
    assert_problem(answer, 422, "content-type: application/json")


@pytest.mark.parametrize("announced", [True, False], ids=["announced", "chunked"])
def test_a_huge_body_is_refused_unread(service, announced):
    size = 50_000_000
    content = b" " * size if announced else itertools.repeat(b" " * 65536, size // 65536)
    answer = service.request("POST", "/v1/basins", content=content, headers={"content-type": "application/json"})
    assert_problem(answer, 413, "at most 1048576 bytes")


@pytest.mark.parametrize(
    ("method", "path", "status", "told"),
    [
        ("GET", "/v1/jobs/nobody", 404, "there is no job nobody"),
        ("DELETE", "/v1/jobs/nobody", 404, "there is no job nobody"),
        ("POST", "/v1/jobs/nobody/cancel", 404, "there is no job nobody"),
        ("GET", "/v1/jobs/nobody/result", 404, "there is no job nobody"),
        ("GET", "/v1/jobs/nobody/picture.png", 404, "there is no job nobody"),
        ("GET", "/v1/jobs/nobody/result.zarr/zarr.json", 404, "there is no job nobody"),
        ("GET", "/v1/jobs?size=0", 422, "query.size"),
        ("GET", "/v1/jobs?before=last", 422, "query.before"),
        ("GET", f"/v1/jobs?before={10**30}", 422, "query.before"),
        ("GET", "/v1/jobs?state=tired", 422, "query.state"),
        ("PUT", "/v1/jobs", 405, "Method Not Allowed"),
        ("GET", "/v1/basins", 405, "Method Not Allowed"),
        ("GET", "/v1/nothing", 404, "there is nothing at /v1/nothing"),
    ],
)
def test_a_wrong_address_is_answered(service, method, path, status, told):
    assert_problem(service.request(method, path), status, told)


@pytest.mark.parametrize(
    "path", ["%2e%2e/%2e%2e/jobs.sqlite", "..%2f..%2fjobs.sqlite", "group/%2e%2e/%2e%2e/%2e%2e/serve.log",
    "%2fetc/passwd", "group", "a%00b", "c" * 5000],
)  # fmt: skip
def test_a_path_outside_the_store_is_not_served(service, path):
    job = service.wait(
        service.submit({"grid": {"time": {"cells": 4}, "velocity": {"cells": 4}}, "iterations": 1})["id"]
    )
    answer = service.request("GET", f"{job['links']['zarr']}/{path}")
    assert answer.status_code == 404 and answer.headers["content-type"] == "application/problem+json"


def test_a_layer_that_there_is_none_of_is_refused(service):
    job = service.wait(
        service.submit({"grid": {"time": {"cells": 4}, "velocity": {"cells": 4}}, "iterations": 1})["id"]
    )
    assert_problem(service.request("GET", f"{job['links']['picture']}?layer=taste"), 422, "query.layer")
