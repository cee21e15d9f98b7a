"""A report over HTTP: a job whose page is opened by a browser, which lets it do nothing."""

import re

import pytest

import rattle
from rattle_machine.report import report
from tests.analysis_requests import GRAZING, REPORT
from tests.service.idle_service import idle_service
from tests.service.routes.problems import assert_problem

PAIR = rattle.GearPair(**REPORT["machine"])
ALONE = {name: value for name, value in REPORT.items() if name != "machine"}


@pytest.fixture(scope="module")
def finished(service):
    # In units of its own, as from the form of the page.
    job = service.wait(
        service.submit(REPORT | {"machine": REPORT["machine"] | {"backlash": "120 mm"}}, "reports")["id"]
    )
    assert job["state"] == "succeeded", job
    return job


@pytest.fixture
def idle(tmp_path, monkeypatch):
    """A service that takes requests and runs none."""
    with idle_service(monkeypatch, tmp_path) as service:
        yield service


def page_of(service, job, **options):
    return service.request("GET", f"/v1/jobs/{job['id']}/report.html", **options)


@pytest.mark.slow
def test_the_page_is_that_of_the_package_and_may_do_nothing(service, finished, tmp_path):
    answer = page_of(service, finished)
    assert answer.status_code == 200 and answer.headers["content-type"] == "text/html; charset=utf-8"
    assert answer.content == report(PAIR, tmp_path / "page.html", prove=False, progress=False, **ALONE).read_bytes()
    policy = dict(each.strip().split(" ", 1) for each in answer.headers["content-security-policy"].split(";"))
    assert policy["default-src"] == "'none'" and "script-src" not in policy
    # What the page holds is what it may: style, and images within its pictures.
    assert "<style>" in answer.text and policy["style-src"] == "'unsafe-inline'" and policy["img-src"] == "data:"
    assert not re.search(r"<script|<iframe|\son\w+=", answer.text)


@pytest.mark.slow
def test_a_page_that_is_known_is_not_sent_again(service, finished):
    first = page_of(service, finished)
    again = page_of(service, finished, headers={"if-none-match": first.headers["etag"]})
    assert again.status_code == 304 and again.content == b""
    policy = "content-security-policy"
    assert again.headers[policy] == first.headers[policy], "a browser takes them for those of what it has"


@pytest.mark.slow
def test_the_job_shows_the_machine_and_the_result_its_answers(service, finished):
    assert finished["request"]["machine"] == PAIR.as_request
    result = service.request("GET", finished["links"]["result"]).json()
    assert result["kind"] == "report" and result["answers"] and len(result["speeds"]) == 3
    rows = service.request("GET", f"/v1/jobs/{finished['id']}/result.json").json()
    assert [row["gamma"] for row in rows] == pytest.approx([each["gamma"] for each in result["speeds"]])
    part = service.request("GET", f"/v1/jobs/{finished['id']}/result.zarr/parts/basin/zarr.json")
    assert part.status_code == 404, "the basin was for the page alone"


def test_a_job_of_another_kind_has_no_page(service):
    other = service.submit(GRAZING, "grazing-curves")
    assert_problem(page_of(service, other), 409, "a page")
    assert_problem(page_of(service, {"id": "0" * 32}), 404, "")


def test_a_report_that_has_not_begun_has_no_page_yet(idle):
    answer = idle.request("POST", "/v1/reports", json=REPORT)
    assert answer.status_code == 202, answer.text
    assert_problem(page_of(idle, answer.json()), 404, "")


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"rate": 1.0}, "give both, or neither"),
        ({"rate": 1.0, "size": "sizes.csv"}, "is no number with a unit"),
        ({"numbers": {"backlash": "wide"}}, "is no tolerance"),
        ({"machine": REPORT["machine"] | {"speed": "4000 rpm"}, "rate": 1.0, "size": 1.0}, "never quiet"),
        ({"machine": REPORT["machine"] | {"backlash": "3 kg"}}, "'3 kg' cannot be in m"),
        ({"machine": "machine.toml"}, "a machine is an object"),
        ({"cell": 3}, "did you mean cells?"),
        ({"cells": 100_000}, "RATTLE_MAX_CELLS"),
        ({"departures": 100_000_000}, "RATTLE_MAX_CELLS"),
        ({"speeds": 100_000}, "RATTLE_MAX_BASINS"),
        ({"machines": 1_000_000}, "RATTLE_MAX_BASINS"),
        ({"cells": 5000, "speeds": 10_000, "departures": 25_000_000}, "RATTLE_MAX_SWEEP_APPLICATIONS"),
    ],
)
def test_what_is_wrong_is_told_before_anything_is_computed(idle, change, told):
    assert_problem(idle.request("POST", "/v1/reports", json=REPORT | change), 422, told)
    checked = idle.request("POST", "/v1/checks", json={"kind": "report"} | REPORT | change).json()
    assert not checked["accepted"] and told in " ".join(error["message"] for error in checked["errors"])
