"""A result whose root was broken is named with what to do, at every address of its job."""

import json
from pathlib import Path

import pytest

from tests.service.idle_service import idle_service
from worker.errors import StoreConflict
from worker.jobs.basin_job import BasinJob, SweepJob, basin_job
from worker.jobs.grazing_curve_job import GrazingCurveJob
from worker.storage.location import result_location
from worker.stores.analysis_store import AnalysisStore
from worker.stores.checking.damage import check_store
from worker.stores.new_store import create_store

GRID = {"time": {"cells": 4}, "velocity": {"cells": 4}}
BODIES = {
    "basins": {"grid": GRID, "iterations": 1},
    "sweeps": {"grid": GRID, "iterations": 1, "vary": [{"parameter": "damping", "values": [0.5, 0.6]}]},
    "grazing-curves": {},
}


@pytest.fixture(scope="module")
def service(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        with idle_service(patch, tmp_path_factory.mktemp("idle")) as service:
            yield service


@pytest.fixture(scope="module")
def results(service):
    """The number of a job of each sort, and its root."""
    numbers = {path: service.request("POST", f"/v1/{path}", json=body).json()["id"] for path, body in BODIES.items()}
    create_store(result_location(service.results, numbers["basins"]), BasinJob.from_request(BODIES["basins"]))
    create_store(result_location(service.results, numbers["sweeps"]), SweepJob.from_request(BODIES["sweeps"]))
    grazing = GrazingCurveJob.from_request(BODIES["grazing-curves"])
    AnalysisStore.create_or_resume(result_location(service.results, numbers["grazing-curves"]), "Curve", grazing)
    return {
        path: (number, Path(result_location(service.results, number)) / "zarr.json") for path, number in numbers.items()
    }


def changed(attributes, **others):
    """A root with other attributes."""
    return lambda root: json.dumps(root | {"attributes": attributes(root["attributes"])} | others)


def without(name):
    return changed(lambda attributes: {key: value for key, value in attributes.items() if key != name})


def having(**values):
    return changed(lambda attributes: attributes | values)


DEEP = 100_000
ROOTS = {
    "list": lambda _: "[]",
    "null": lambda _: "null",
    "number": lambda _: "1",
    "text": lambda _: '"basin"',
    "nothing": lambda _: "",
    "attributes-alone": lambda _: '{"attributes": []}',
    "attributes-a-list": changed(lambda _: []),
    "attributes-a-number": changed(lambda _: 1),
    "deep": lambda _: "[" * DEEP + "]" * DEEP,
    "deep-unclosed": lambda _: "[" * DEEP,
    "deep-attribute": lambda root: json.dumps(root).replace('"complete": false', '"a": ' + "[" * DEEP + "]" * DEEP),
    "consolidated-a-number": changed(dict, consolidated_metadata=1),
    "no-request": without("request"),
    "no-complete": without("complete"),
    "request-a-number": having(request=1),
    "request-no-json": having(request="basin"),
    "request-a-list": having(request="[]"),
    "request-null": having(request="null"),
    "request-deep": having(request="[" * DEEP),
    "request-of-other-fields": having(request='{"a": 1}'),
    "request-outside-domain": having(request='{"oscillator": {"eccentricity": 100.0}}'),
}


OTHER_GRID = {"time": {"cells": 5}, "velocity": {"cells": 4}}
SWEPT = BODIES["sweeps"] | {"vary": [{"parameter": "damping", "values": [0.5, 0.6, 0.7]}]}
OTHERS = {
    "basin-of-other-numbers": ("basins", BODIES["basins"] | {"oscillator": {"damping": 0.7}}),
    "basin-of-more-cells": ("basins", BODIES["basins"] | {"grid": OTHER_GRID}),
    "basin-of-many-tiles": (
        "basins",
        BODIES["basins"] | {"grid": {"time": {"cells": 300}, "velocity": {"cells": 300}}},
    ),
    "sample": ("basins", {"iterations": 1, "sample": {"points": 16}}),
    "sweep-in-a-basin": ("basins", BODIES["sweeps"]),
    "sweep-of-more-basins": ("sweeps", SWEPT),
    "basin-in-a-sweep": ("sweeps", BODIES["basins"]),
    "curve-of-other-order": ("grazing-curves", {"order": 3}),
}


def addresses(service, number):
    """All GET routes of a job but the events, which have no end, from the document."""
    known = {"{job_id}": number, "{path}": "zarr.json", "{kind}": "grazing", "{number}": "0"}
    for path, operations in service.app.openapi()["paths"].items():
        if "{job_id}" in path and "get" in operations and not path.endswith("/events"):
            for name, value in known.items():
                path = path.replace(name, value)
            yield path


QUICK = "list", "nothing", "deep-attribute", "no-request", "request-null", "request-outside-domain"
OF_ALL = "attributes-a-list", "deep", "no-request", "request-a-list"


@pytest.mark.parametrize(
    ("sort", "broken"),
    [
        pytest.param(sort, broken, marks=() if sort == "basins" and broken in QUICK else pytest.mark.slow)
        for sort in BODIES
        for broken in ROOTS
        if sort == "basins" or broken in OF_ALL
    ],
)
def test_a_broken_root_is_named_with_what_to_do(service, results, sort, broken):
    number, root = results[sort]
    whole = root.read_text()
    root.write_text(ROOTS[broken](json.loads(whole)))
    try:
        answers = {path: service.request("GET", path) for path in addresses(service, number)}
    finally:
        root.write_text(whole)
    assert_named(service, number, answers, "cannot be read")


def assert_named(service, number, answers, what):
    assert answers.pop(f"/v1/jobs/{number}").status_code == 200
    named = 0
    for path, answer in answers.items():
        assert answer.status_code in (200, 409, 503), (path, answer.text)  # 200: the file itself; 409: of another kind
        if answer.status_code == 503:
            named += 1
            told = answer.json()
            assert told["type"] == "/problems/store-failed" and what in told["detail"]
            assert "`rattle check`" in told["detail"] and service.results not in told["detail"]
    assert named >= 5


# Nothing else in a store contradicts a root of such a request and its digest.
OF_THE_SAME_SHAPE = "basin-of-other-numbers", "curve-of-other-order"


@pytest.mark.parametrize(
    ("other", "with_digest"),
    [(other, with_digest) for other in OTHERS for with_digest in (False, True)[: 2 - (other in OF_THE_SAME_SHAPE)]],
)
def test_the_request_of_another_store_is_named_with_what_to_do(service, results, other, with_digest):
    sort, body = OTHERS[other]
    number, root = results[sort]
    job = GrazingCurveJob.from_request(body) if sort == "grazing-curves" else basin_job(body)
    attributes = {"request": json.dumps(job.request())}
    what = "does not have the digest that was stored with it"
    if with_digest:
        attributes["request_sha256"], what = job.digest, "is no array of its request"
    whole = root.read_text()
    root.write_text(having(**attributes)(json.loads(whole)))
    try:
        answers = {path: service.request("GET", path) for path in addresses(service, number)}
        with pytest.raises(StoreConflict, match="has lost its request.* put back a copy of its zarr.json"):
            check_store(str(root.parent))
    finally:
        root.write_text(whole)
    assert_named(service, number, answers, what)
