"""The whole API, asked at random: no answer is a 5xx, and every answer is as the OpenAPI document says."""

import re
import zlib

import hypothesis
import pytest
import schemathesis
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi import checks

from service.answers import previews
from service.app import create_app
from service.records.job_record import JobState
from service.settings import Settings
from tests.service.idle_service import idle_service
from worker.jobs.basin_job import basin_job
from worker.stores.new_store import create_store

AS_DESCRIBED = (
    not_a_server_error,
    checks.status_code_conformance,
    checks.content_type_conformance,
    checks.response_headers_conformance,
    checks.response_schema_conformance,
)
REFUSED = (checks.negative_data_rejection, checks.unsupported_method)
SCHEMA = schemathesis.openapi.from_dict(create_app(Settings.model_construct()).openapi())
FEW, MANY = 4, 300
# A first preview with harmonics compiles its kernels.
_SECONDS = 120


@pytest.fixture(scope="module")
def service(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        limits = {"max_samples": 1000, "max_contacts": 1000}
        patch.setattr(previews, "_MOST_SECONDS", 0.25)
        with idle_service(patch, tmp_path_factory.mktemp("idle"), **limits) as service:
            service.ended = service.add_job()
            service.jobs.transition(service.ended.id, JobState.QUEUED, JobState.SUCCEEDED)
            create_store(f"{service.results}/{service.ended.id}.zarr", basin_job(service.ended.request))
            yield service


def spare_compiling(case):
    """Ask for two harmonics or for none: kernels are compiled for each of these numbers."""
    body = case.body if isinstance(case.body, dict) else {}
    oscillator = body.get("oscillator")
    if case.meta is None or not case.meta.generation.mode.is_positive or not isinstance(oscillator, dict):
        return
    oscillator.pop("transmission_error", None)
    harmonics = oscillator.pop("harmonics", ())
    if len(harmonics) > 1:
        oscillator["harmonics"] = harmonics[:2]


def ask(service, case):
    spare_compiling(case)
    # Of a job that there is, too: half of the time, as the case itself has it, so that a failure is found again.
    if (
        "job_id" in (case.path_parameters or {})
        and case.method == "GET"
        and zlib.crc32(repr(case.headers).encode()) % 2
    ):
        case.path_parameters["job_id"] = service.ended.id
        case.call_and_validate(base_url=service.url, checks=AS_DESCRIBED, timeout=_SECONDS)
    else:
        case.call_and_validate(base_url=service.url, checks=AS_DESCRIBED + REFUSED, timeout=_SECONDS)


def asked(operation, examples):
    """A test of one operation; those that schemathesis makes of a whole schema share one id, and xdist runs one."""

    @SCHEMA.include(path=operation.path, method=operation.method.upper()).parametrize()
    @hypothesis.settings(max_examples=examples, deadline=None, derandomize=True, database=None)
    def test(service, case):
        ask(service, case)

    return test


for _result in SCHEMA.get_all_operations():
    _operation = _result.ok()
    _name = re.sub(r"\W+", "_", f"{_operation.method}{_operation.path}").strip("_")
    globals()[f"test_{_name}_answers_as_described"] = asked(_operation, FEW)
    globals()[f"test_{_name}_answers_as_described_many_times"] = pytest.mark.slow(asked(_operation, MANY))


def test_without_a_key_every_route_answers_as_the_document_says(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path, require_keys=True) as service:
        for path, operations in service.request("GET", "/openapi.json").json()["paths"].items():
            for method, operation in operations.items():
                status = service.request(method.upper(), re.sub("{.*?}", "x", path)).status_code
                assert str(status) in operation["responses"]
                assert (status == 401) == ("security" in operation)
