"""Any body whatever of any route that takes one gets an answer below 500, and the event loop checks none of it."""

import json
import threading

import pytest
from fastapi.routing import iter_route_contexts
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from service.answers import checks as checked
from service.answers import limits
from service.routes.plain_json import PlainJsonRoute
from tests.service.idle_service import idle_service
from worker.jobs.oscillator_request import _Common
from worker.jobs.preview_request import PreviewRequest
from worker.jobs.trajectory_request import TrajectoryRequest
from worker.kinds import KINDS


@pytest.fixture(scope="module")
def service(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        with idle_service(patch, tmp_path_factory.mktemp("idle")) as service:
            yield service


def paths_with_bodies(service):
    """Every path that takes a JSON body, from the application's own routes."""
    return sorted(
        context.path
        for context in iter_route_contexts(service.app.routes)
        if isinstance(context.original_route, PlainJsonRoute)
    )


NUMBERS = st.one_of(
    st.integers(), st.floats(), st.sampled_from([10**30, -(10**310), 2**63, 10**18, 1e308, -0.0, 5e-324])
)
TEXTS = st.one_of(st.text(st.characters(exclude_categories=()), max_size=8), st.sampled_from(["damping", "phase_2"]))
VALUES = st.recursive(
    st.one_of(st.none(), st.booleans(), NUMBERS, TEXTS),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(TEXTS, inner, max_size=4)),
    max_leaves=12,
)
FIELDS = sorted(
    {name.rstrip("_") for kind in KINDS.values() for name in kind.job_class.model_fields}
    | TrajectoryRequest.model_fields.keys()
    | PreviewRequest.model_fields.keys()
)
PARTS = [
    "time", "velocity", "cells", "start", "stop", "count", "values", "parameter", "spacing", "order", "amplitude",
    "phase", "points", "seed", "scramblings", "itinerary", "period", "chord", "angle", "finest", "most_points",
    "displacement", "model", *_Common.model_fields, "stiffness", "error", "unit", "explained", "scale",
]  # fmt: skip
INNER = st.one_of(VALUES, st.dictionaries(st.sampled_from(PARTS), VALUES, max_size=3))
PART = st.one_of(INNER, st.lists(INNER, max_size=3), st.dictionaries(st.sampled_from(PARTS), INNER, max_size=3))
BODIES = st.one_of(VALUES, st.dictionaries(st.sampled_from(FIELDS), PART, max_size=4))


MACHINE = {
    "speed": 100, "inertia": 1, "drag_torque": "1 N m", "base_radius": 1, "backlash": 1, "transmission_error": 0.01,
}  # fmt: skip
OSCILLATOR = {"damping": 0.6, "eccentricity": 0.1, "half_backlash": 0.6}


def sent(value):
    return json.dumps(value).encode()


@pytest.mark.parametrize("path", ["basins", "sweeps", "bifurcations", "orbits", "manifolds", "grazing-curves", "checks",
    "trajectories", "previews", "reports", "charts", "machines"])  # fmt: skip
@given(body=BODIES)
@settings(max_examples=10, deadline=None, suppress_health_check=list(HealthCheck))
@example(body={"vary": [{"parameter": "\ud800", "values": [1]}]})
@example(body={"kind": [1]})
@example(body={"kind": {}})
@example(body={"kind": "sweep", "vary": {"parameter": "damping"}})
@example(body={"grid": {"time": {"cells": 10**300}, "velocity": {"cells": 10**300}}})
@example(body={"cells": 10**300, "longest": 10**300})
@example(body={"transient": 10**300, "vary": {"parameter": "damping", "start": 0.5, "stop": 0.6, "count": 10**300}})
@example(body={"sample": {"points": 10**300, "seed": 10**300}})
@example(body={"start": {"velocity": 3.0}, "periods": 1e308, "samples_per_period": 10**300})
@example(body={"saddles": [{"itinerary": "P(1,1,0)"}], "arclength": 1e308, "resolution": {"chord": 5e-324}})
@example(body={"saddles": [{"itinerary": "P(1,1,0)"}], "arclength": 1e9, "resolution": {"chord": 0}})
@example(body={"seeds": [{"time": 1e308, "velocity": 5e-324, "period": 10**300}]})
@example(body={"oscillator": {"damping": 5e-324, "half_backlash": 1e308}})
@example(body={"oscillator": {"transmission_error": {"angle": [0, 1e308, 1.7e308], "error": [1e308, -1e308, 0]}}})
@example(body={"oscillator": {"model": "piecewise_linear", "stiffness": 5e-324, "damping": 1e308}})
@example(body={"machine": 1, "oscillator": {}})
@example(body={"machine": {}, "oscillator": {}})
@example(body={"machine": MACHINE | {"speed": 10**300}})
@example(body={"machine": MACHINE | {"speed": "9e999 rpm"}, "oscillator": OSCILLATOR})
@example(body={"machine": MACHINE | {"backlash": [1, "\ud800"]}, "oscillator": OSCILLATOR})
@example(body={"machine": MACHINE | {"transmission_error": {"1e300": {"amplitude": {}}}}, "oscillator": OSCILLATOR})
@example(body=MACHINE | {"inertia": "1e300 lb ft^2", "turns": 10**300})
def test_any_json_is_answered_below_500(service, path, body):
    answer = service.request("POST", f"/v1/{path}", content=sent(body), headers={"content-type": "application/json"})
    assert answer.status_code < 500, (body, answer.text)
    if answer.status_code >= 400:
        told = answer.json()
        assert told["detail"] and told["status"] == answer.status_code


def test_these_are_all_routes_that_take_a_body(service):
    assert [path.removeprefix("/v1/") for path in paths_with_bodies(service)] == sorted(
        ["basins", "sweeps", "bifurcations", "orbits", "manifolds", "grazing-curves", "reports", "charts", "checks",
         "machines", "trajectories", "previews"]
    )  # fmt: skip


@given(raw=st.binary(max_size=40))
@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
@example(raw=b'{"a": "\xed\xa0\x80"}')
@example(raw=b"\xff\xfe{\x00}\x00")
@example(raw=b'{"iterations": ' + 5000 * b"9" + b"}")
@example(raw=b'{"grid": ' * 900 + b"1" + b"}" * 900)
def test_any_bytes_are_answered_below_500(service, raw):
    for path in ("basins", "checks", "previews"):
        headers = {"content-type": "application/json"}
        assert service.request("POST", f"/v1/{path}", content=raw, headers=headers).status_code < 500


@pytest.fixture
def threads_that_check(monkeypatch):
    """Names of the threads in which requests are checked."""
    names = set()

    def noting(function):
        return lambda *given, **named: (names.add(threading.current_thread().name), function(*given, **named))[1]

    monkeypatch.setattr(limits, "job_from", noting(limits.job_from))
    monkeypatch.setattr(checked, "job_from", noting(checked.job_from))
    for model in (TrajectoryRequest, PreviewRequest):
        monkeypatch.setattr(model, "model_validate", noting(model.model_validate))
    return names


def test_no_request_is_checked_in_the_event_loop(service, threads_that_check):
    asked = {kind.path: {} for kind in KINDS.values()} | {"checks": {}, "trajectories": {}, "previews": {"kind": 1}}
    for path, body in asked.items():
        threads_that_check.clear()
        service.request("POST", f"/v1/{path}", json=body)
        assert threads_that_check and all("rattle-checks" in name for name in threads_that_check), path


def test_an_object_of_too_many_keys_is_refused_without_a_word_for_each(service):
    answer = service.request("POST", "/v1/basins", json={f"k{number}": 1 for number in range(50_000)})
    assert answer.status_code == 422 and len(answer.content) < 1000


def test_a_list_of_wrong_values_is_refused_at_its_first(service):
    answer = service.request("POST", "/v1/sweeps", json={"vary": [{"parameter": "damping", "values": ["a"] * 100_000}]})
    assert answer.status_code == 422 and len(answer.content) < 1000
    assert [each["location"][-1] for each in answer.json()["errors"]] == [0]
