"""The schema of requests says what the service demands of them, as far as a schema can."""

import jsonschema_rs
import pytest

from service.openapi import document
from tests.analysis_requests import CHART, REPORT
from worker.jobs.preview_request import PreviewRequest
from worker.jobs.trajectory_request import TrajectoryRequest
from worker.kinds import KINDS

SEED = {"time": 0.5, "velocity": 3.0}
DAMPING = {"parameter": "damping", "values": [0.5, 0.6]}
CURVE = {"angle": [0.0, 0.25, 0.5, 0.75], "error": [0.1, 0.0, -0.1, 0.0], "scale": 0.1}
ITERATIONS = 10**12
MODELS = {kind.path: kind.job_class for kind in KINDS.values()} | {
    "trajectories": TrajectoryRequest, "previews": PreviewRequest
}  # fmt: skip

# Each is refused by what is said in its schema; beside it, the nearest that is right.
REFUSED = {
    "cells-of-0": ("basins", {"grid": {"time": {"cells": 0}}}, {"grid": {"time": {"cells": 1}}}),
    "order-of-1": (
        "basins", {"oscillator": {"harmonics": [{"order": 1, "amplitude": 0.01}]}},
        {"oscillator": {"harmonics": [{"order": 2, "amplitude": 0.01}]}},
    ),
    "departure-at-rest": ("bifurcations", {"vary": DAMPING, "seeds": [SEED | {"velocity": 0}]},
                          {"vary": DAMPING, "seeds": [SEED]}),
    "period-of-0": ("orbits", {"seeds": [SEED | {"period": 0}]}, {"seeds": [SEED | {"period": 1}]}),
    "period-too-long": ("orbits", {"seeds": [SEED | {"period": 10_000}]}, {"seeds": [SEED | {"period": 9999}]}),
    "longest-too-long": ("orbits", {"longest": 10_000}, {"longest": 9999}),
    "one-point-each-way": (
        "orbits",
        {"continuation": {"parameter": "damping", "start": 0.5, "stop": 0.7, "most_points": 1}},
        {"continuation": {"parameter": "damping", "start": 0.5, "stop": 0.7, "most_points": 2}},
    ),
    "seeds-and-longest": ("orbits", {"seeds": [SEED], "longest": 2}, {"longest": 2}),
    "curves-alone": (
        "orbits",
        {"curves": {"parameter": "eccentricity", "start": 0.05, "stop": 0.12}},
        {"continuation": {"parameter": "damping", "start": 0.5, "stop": 0.7},
         "curves": {"parameter": "eccentricity", "start": 0.05, "stop": 0.12}},
    ),
    "phase-beyond-1": ("orbits", {"region": {"time": {"start": 0, "stop": 1.5}}},
                       {"region": {"time": {"start": 0, "stop": 1}}}),
    "speed-below-0": ("orbits", {"region": {"velocity": {"start": -1, "stop": 7}}},
                      {"region": {"velocity": {"start": 0, "stop": 7}}}),
    "itinerary": ("manifolds", {"saddles": [{"itinerary": "P(1,1)"}]}, {"saddles": [{"itinerary": "P(1,1,0)"}]}),
    "itinerary-of-no-period": ("manifolds", {"saddles": [{"itinerary": "P(0,1,0)"}]},
                               {"saddles": [{"itinerary": "P(10,1,0)"}]}),
    "itinerary-of-zeros": ("manifolds", {"saddles": [{"itinerary": "P(00,1,0)"}]},
                           {"saddles": [{"itinerary": "P(01,1,0)"}]}),
    "saddle-of-nothing": ("manifolds", {"saddles": [{}]}, {"saddles": [SEED]}),
    "saddle-of-a-phase": ("manifolds", {"saddles": [{"time": 0.5}]}, {"saddles": [SEED]}),
    "saddle-named-twice": ("manifolds", {"saddles": [SEED | {"itinerary": "P(1,1,0)"}]}, {"saddles": [SEED]}),
    "arclength-of-0": ("manifolds", {"saddles": [SEED], "arclength": 0}, {"saddles": [SEED], "arclength": 1}),
    "few-points-of-a-branch": ("manifolds", {"saddles": [SEED], "most_points": 99},
                               {"saddles": [SEED], "most_points": 100}),
    "manifold-of-springs": (
        "manifolds",
        {"saddles": [SEED], "oscillator": {"model": "piecewise_linear", "stiffness": 1000}},
        {"saddles": [SEED], "oscillator": {"model": "impacting"}},
    ),
    "speeds-of-a-curve": ("grazing-curves", {"velocity": {"start": -1, "stop": 7}},
                          {"velocity": {"start": 0, "stop": 7}}),
    "order-below-0": ("grazing-curves", {"order": -1}, {"order": 0}),
    "few-points": ("grazing-curves", {"most_points": 999}, {"most_points": 1000}),
    "chord-of-0": ("grazing-curves", {"resolution": {"chord": 0}}, {"resolution": {"chord": 0.1}}),
    "sample-too-large": ("basins", {"sample": {"points": 2**30 + 1}}, {"sample": {"points": 2**30}}),
    "many-scramblings": ("basins", {"sample": {"points": 2002, "scramblings": 1001}},
                         {"sample": {"points": 2000, "scramblings": 1000}}),
    "sample-of-cells": ("basins", {"sample": {"points": 64}, "grid": {"time": {"cells": 8}}},
                        {"sample": {"points": 64}, "grid": {"time": {"start": 0}}}),
    "iterations": ("basins", {"iterations": ITERATIONS + 1}, {"iterations": 1}),
    "proven-sweep": ("sweeps", {"vary": [DAMPING], "prove": True}, {"vary": [DAMPING], "prove": False}),
    "no-values": ("sweeps", {"vary": [{"parameter": "damping", "values": []}]}, {"vary": [DAMPING]}),
    "values-and-range": ("sweeps", {"vary": [DAMPING | {"start": 0.5}]}, {"vary": [DAMPING]}),
    "neither-values-nor-range": ("bifurcations", {"vary": {"parameter": "damping", "start": 0.5}},
                                 {"vary": {"parameter": "damping", "start": 0.5, "stop": 0.6, "count": 2}}),
    "geometric-from-0": (
        "sweeps",
        {"vary": [{"parameter": "eccentricity", "start": 0, "stop": 0.1, "count": 3, "spacing": "geometric"}]},
        {"vary": [{"parameter": "eccentricity", "start": 0.01, "stop": 0.1, "count": 3, "spacing": "geometric"}]},
    ),
    "forcing-given-twice": ("basins", {"oscillator": {"eccentricity": 0.1, "transmission_error": CURVE}},
                            {"oscillator": {"transmission_error": CURVE}}),
    "curve-of-two": (
        "basins", {"oscillator": {"transmission_error": {"angle": [0, 0.5], "error": [0.1, 0]}}},
        {"oscillator": {"transmission_error": CURVE}},
    ),
    "scale-of-0": ("basins", {"oscillator": {"transmission_error": CURVE | {"scale": 0}}},
                   {"oscillator": {"transmission_error": CURVE}}),
    "seeds-and-region": ("bifurcations", {"vary": DAMPING, "seeds": [SEED], "region": {}},
                         {"vary": DAMPING, "region": {}}),
    "departure-of-a-history": ("trajectories", {"start": {"velocity": 0}},
                               {"start": {"velocity": 0, "displacement": 0.1}}),
    "displacement": ("trajectories", {"start": {"velocity": 0, "displacement": 2e6}},
                     {"start": {"velocity": 0, "displacement": 0.1}}),
    "report-at-one-speed": ("reports", REPORT | {"speeds": 1}, REPORT | {"speeds": 2}),
    "report-of-no-machine": ("reports", {"speeds": 3}, REPORT),
    "iterations-of-a-preview": ("previews", {"iterations": ITERATIONS + 1}, {"iterations": 127}),
}  # fmt: skip


@pytest.fixture(scope="module")
def schemas():
    """What a schema refuses, by path."""
    whole = document()

    def of(path):
        body = whole["paths"][f"/v1/{path}"]["post"]["requestBody"]["content"]["application/json"]["schema"]
        return jsonschema_rs.Draft202012Validator({"components": whole["components"]} | body)

    return {path: of(path) for path in MODELS}


def accepted(path, body):
    model = MODELS[path]
    try:
        if hasattr(model, "from_request"):
            model.from_request(body)
        else:
            request = model.model_validate(body)
            request.checked() if path == "previews" else request.follow(1)
    except ValueError:
        return False
    return True


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused_is_refused_by_the_schema(schemas, name):
    path, wrong, right = REFUSED[name]
    assert not accepted(path, wrong) and accepted(path, right)
    assert schemas[path].is_valid(right) and not schemas[path].is_valid(wrong)


@pytest.mark.parametrize("kind", KINDS.values(), ids=lambda kind: kind.path)
def test_examples_and_canonical_requests_are_valid(schemas, kind):
    for example in kind.job_class.model_config["json_schema_extra"]["examples"]:
        assert schemas[kind.path].is_valid(example)
        assert schemas[kind.path].is_valid(kind.job_class.from_request(example).request())


WHOLE = {
    "basins": {"grid": {"time": {"cells": 8}}, "iterations": 127, "oscillator": {"harmonics": [
        {"order": 2, "amplitude": 0.01}]}, "prove": {"levels": 2}},
    "sweeps": {"vary": [{"parameter": "damping", "start": 0.5, "stop": 0.6, "count": 3}],
               "sample": {"points": 64, "seed": 3, "scramblings": 2}},
    "bifurcations": {"vary": DAMPING, "transient": 10, "kept": 2},
    "orbits": {"seeds": [SEED | {"period": 2}]},
    "manifolds": {"saddles": [SEED | {"period": 2}], "most_points": 1000, "cells": 20},
    "grazing-curves": {"order": 3, "most_points": 1000},
    "reports": REPORT,
    "charts": CHART,
}  # fmt: skip


def with_fractions(part):
    """The same, with every integer written as 4.0, which JSON Schema takes for the integer 4."""
    if isinstance(part, dict):
        return {name: with_fractions(each) for name, each in part.items()}
    if isinstance(part, list):
        return [with_fractions(each) for each in part]
    return float(part) if isinstance(part, int) else part


@pytest.mark.parametrize("path", WHOLE)
def test_an_integer_may_be_written_with_a_fraction_of_0(schemas, path):
    written = with_fractions(WHOLE[path])
    assert schemas[path].is_valid(written)
    assert MODELS[path].from_request(written).request() == MODELS[path].from_request(WHOLE[path]).request()
    assert MODELS[path].from_request(written).digest == MODELS[path].from_request(WHOLE[path]).digest
