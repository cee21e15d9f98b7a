"""A sweep over HTTP, as a client sees it, and what is refused."""

import numpy as np
import pytest
import xarray as xr

from tests.running_service import running_service
from tests.service.routes.problems import assert_problem, left_behind

REQUEST = {
    "oscillator": {"eccentricity": 0.1, "half_backlash": 0.6},
    "vary": [{"parameter": "damping", "start": 0.55, "stop": 0.65, "count": 3}],
    "grid": {"time": {"cells": 24}, "velocity": {"cells": 20}},
    "iterations": 101,
}


def submitted(service, body):
    answer = service.request("POST", "/v1/sweeps", json=body)
    assert answer.status_code == 202, answer.text
    return answer.json()


@pytest.fixture(scope="module")
def finished(service):
    return service.wait(submitted(service, REQUEST)["id"])


def test_a_sweep_is_a_job_with_its_values_spelt_out(service, finished):
    assert finished["kind"] == "sweep" and finished["state"] == "succeeded", finished
    assert finished["request"]["vary"] == [{"parameter": "damping", "values": [0.55, 0.6, 0.65]}]
    assert finished["progress"]["basins_done"] == finished["progress"]["basins_total"] == 3
    otherwise = REQUEST | {"vary": [{"parameter": "damping", "values": [0.55, 0.6, 0.65]}]}
    assert submitted(service, otherwise)["id"] == finished["id"]


def test_the_result_has_shares_basin_by_basin(service, finished):
    result = service.request("GET", finished["links"]["result"]).json()
    names = [solution["name"] for solution in result["solutions"]]
    assert result["complete"] and names[0] == "permanent contact" and "P(1,1,0)" in names
    assert [basin["parameters"] for basin in result["basins"]] == [{"damping": d} for d in (0.55, 0.6, 0.65)]
    for basin in result["basins"]:
        assert basin["complete"] and sum(each["share"] for each in basin["shares"]) == pytest.approx(1.0)
        assert all(each["standard_error"] is None for each in basin["shares"])
        assert basin["expected"]["undecided_share"] == 0.0 and basin["expected"]["impact_power"] > 0.0
    means = np.zeros(len(names))
    for basin in result["basins"]:
        for each in basin["shares"]:
            means[each["solution"]] += each["share"] / 3
    assert [solution["share"] for solution in result["solutions"]] == pytest.approx(means.tolist())
    assert {(each["kind"], names[each["solution"]], each["before"]) for each in result["changes"]} >= {
        ("death", "P(1,2,0)", 0.55), ("birth", "chaotic", 0.55),
    }  # fmt: skip


def test_tables_say_how_loud_motions_and_basins_are(service, finished):
    result = service.request("GET", finished["links"]["result"]).json()
    assert result["solutions"][0]["impact_power"] == 0.0
    path = f"/v1/jobs/{finished['id']}/result.json"
    basins = service.request("GET", f"{path}?table=damping").json()
    expected = [basin["expected"]["impact_power"] for basin in result["basins"]]
    assert [row["expected_impact_power"] for row in basins] == pytest.approx(expected)
    motions = service.request("GET", path).json()
    assert all(row["impact_power"] is not None for row in motions)
    first = next(row for row in motions if row["name"] == "P(1,1,0)")
    assert first["largest_impact_speed"] == pytest.approx(2.0 * np.pi * first["damping"])


def test_the_store_and_the_picture_of_a_sweep_are_served(service, finished):
    with xr.open_zarr(service.url + finished["links"]["zarr"]) as sweep:
        assert sweep.solution.sel(damping=0.6).dims == ("velocity", "time")
    answer = service.request("GET", finished["links"]["picture"])
    assert answer.headers["content-type"] == "image/png" and answer.content.startswith(b"\x89PNG")


def test_the_chart_of_shares_is_served_of_sweeps_alone(service, finished):
    answer = service.request("GET", finished["links"]["shares"])
    assert answer.headers["content-type"] == "image/png" and answer.content.startswith(b"\x89PNG")
    body = {"grid": {"time": {"cells": 12}, "velocity": {"cells": 12}}, "iterations": 101}
    basin = service.wait(service.submit(body)["id"])
    assert basin["links"]["shares"] is None
    refused = service.request("GET", f"/v1/jobs/{basin['id']}/shares.png")
    assert_problem(refused, 409, "is of kind basin: only jobs of kind sweep have shares over a parameter")
    assert_problem(service.request("GET", "/v1/jobs/0/shares.png"), 404, "there is no job 0")


def test_a_single_basin_is_the_sweep_of_nothing(service):
    body = {"grid": {"time": {"cells": 12}, "velocity": {"cells": 12}}, "iterations": 101}
    job = service.wait(service.submit(body)["id"])
    result = service.request("GET", job["links"]["result"]).json()
    assert job["kind"] == "basin" and "vary" not in job["request"]
    assert [basin["parameters"] for basin in result["basins"]] == [{}] and result["changes"] == []
    shares = {each["solution"]: each["share"] for each in result["basins"][0]["shares"]}
    assert list(shares.values()) == [solution["share"] for solution in result["solutions"]]


def test_a_sample_has_standard_errors_and_no_cells(service):
    body = {"sample": {"points": 500, "seed": 1}, "iterations": 101}
    job = service.wait(service.submit(body)["id"])
    assert job["request"]["sample"] == {"points": 500, "seed": 1} and "cells" not in job["request"]["grid"]["time"]
    result = service.request("GET", job["links"]["result"]).json()
    for each in result["basins"][0]["shares"]:
        # Binomial, but for less than one point of 500.
        assert each["standard_error"] == pytest.approx(
            (each["share"] * (1.0 - each["share"]) / 500) ** 0.5, abs=1 / 500
        )
    assert service.request("GET", job["links"]["picture"]).content.startswith(b"\x89PNG")
    assert_problem(service.request("GET", f"{job['links']['picture']}?layer=group"), 422, "no group")


def test_a_list_of_machines_is_a_sweep_over_its_coordinate(service):
    body = {name: value for name, value in REQUEST.items() if name != "vary"} | {"design": MACHINES}
    job = service.wait(submitted(service, body)["id"])
    assert job["kind"] == "sweep" and job["state"] == "succeeded" and job["request"]["design"]["units"] == "rpm"
    result = service.request("GET", job["links"]["result"]).json()
    assert [basin["parameters"] for basin in result["basins"]] == [{"speed": 800.0}, {"speed": 1000.0}]
    rows = service.request("GET", f"/v1/jobs/{job['id']}/result.json?table=speed").json()
    assert [(row["speed"], row["damping"], row["half_backlash"]) for row in rows] == [(800, 0.7, 0.6), (1000, 0.6, 0.5)]
    for path in (job["links"]["picture"], job["links"]["shares"]):
        assert service.request("GET", path).content.startswith(b"\x89PNG")
    outline = service.request("GET", f"/v1/jobs/{job['id']}/outline?panel=1").json()
    assert outline["parameters"] == {"speed": 1000.0}
    assert service.request("POST", "/v1/checks", json=body).json()["accepted"]


def vary(*swept):
    return {"vary": list(swept)}


def design(**changes):
    return {"design": MACHINES | changes}


MACHINES = {
    "name": "speed", "units": "rpm", "values": [800, 1000],
    "parameters": {"damping": [0.7, 0.6], "half_backlash": [0.6, 0.5]},
}  # fmt: skip
DAMPING = {"parameter": "damping", "values": [0.5, 0.6]}
STIFF = {"oscillator": {"model": "piecewise_linear", "stiffness": 1e4, "eccentricity": 0.1, "half_backlash": 0.6}}
REFUSED = [
    ({}, "Field required: the swept parameters, or else a design", ["body", "vary"]),
    (vary(), "at least 1 item", ["body", "vary"]),
    (vary(DAMPING | {"values": []}), "damping needs at least one value", ["body", "vary", 0, "values"]),
    (vary(DAMPING, DAMPING), "damping is swept twice", ["body", "vary", 1, "parameter"]),
    (vary({"parameter": "stiffness", "values": [100, 200]}), "impacting model", ["body", "vary", 0, "parameter"]),
    (vary({"parameter": "colour", "values": [1]}), "vary.0.parameter", ["body", "vary", 0, "parameter"]),
    (vary(DAMPING | {"values": [0.5, 0.0]}), "value 1 of damping", ["body", "vary", 0, "values", 1]),
    (vary(DAMPING | {"values": [0.5, 0.2]}) | STIFF, "value 1 of damping", ["body", "vary", 0, "values", 1]),
    (
        vary(DAMPING | {"values": [0.5, 0.2]}) | STIFF,
        "below epsilon_crit1 = 0.06",
        ["body", "vary", 0, "values", 1],
    ),
    (
        vary({"parameter": "eccentricity", "values": [0.1, 0.15, 0.19]}, DAMPING) | STIFF,
        "value 2 of eccentricity (at eccentricity = 0.19, damping = 0.5)",
        ["body", "vary", 0, "values", 2],
    ),
    (vary(DAMPING | {"values": [0.5, 0.5]}), "number 1 is 0.5 after 0.5", ["body", "vary", 0, "values", 1]),
    (vary(DAMPING | {"values": [0.5, 0.6, 0.55]}), "number 2 is 0.55", ["body", "vary", 0, "values", 2]),
    (vary(DAMPING | {"start": 0.1}), "either values, or start, stop and count", ["body", "vary", 0]),
    (vary({"parameter": "damping", "start": 0.5, "stop": 0.6}), "either values, or", ["body", "vary", 0]),
    (
        vary({"parameter": "eccentricity", "start": 0, "stop": 0.1, "count": 3, "spacing": "geometric"}),
        "spaced geometrically",
        ["body", "vary", 0, "spacing"],
    ),
    (vary({"parameter": "damping", "start": 0.5, "stop": 0.6, "count": 1}), "greater than or equal to 2", None),
    (
        vary({"parameter": "damping", "start": 0.5, "stop": 0.6, "count": 10**9}),
        "limit of 10000 (RATTLE_MAX_BASINS)",
        None,
    ),
    (
        vary(DAMPING | {"values": list(range(1, 202))}, {"parameter": "half_backlash", "values": list(range(1, 101))}),
        "20100 basins are more than the limit of 10000",
        None,
    ),
    (vary(DAMPING, DAMPING, DAMPING), "at most 2 items", ["body", "vary"]),
    (vary(DAMPING) | {"sample": {"points": 10}, "grid": {"time": {"cells": 5}}}, "leave out grid.time.cells", None),
    (vary(DAMPING) | {"sample": {"points": 0}}, "greater than or equal to 1", ["body", "sample", "points"]),
    (vary(DAMPING) | {"sample": {"points": 10**9}}, "RATTLE_MAX_CELLS", None),
    (vary(DAMPING) | design(), "vary, or a design, not both", ["body", "design"]),
    (design(values=[800]), "2 values for 1 machines", ["body", "design", "parameters", "damping"]),
    (design(parameters={}), "at least 1 item", ["body", "design", "parameters"]),
    (design(name="time"), "a name of results already", ["body", "design", "name"]),
    (
        design(parameters={"damping": [0.7, 0.2]}) | STIFF,
        "machine 1 (at speed = 1000 rpm): eccentricity must be below",
        ["body", "design", "values", 1],
    ),
    (
        design(values=list(range(10_001)), parameters={"damping": [0.6] * 10_001}),
        "10001 basins are more than the limit of 10000",
        None,
    ),
]


@pytest.mark.parametrize(("body", "told", "place"), REFUSED, ids=lambda part: str(part)[:60])
def test_a_wrong_sweep_is_refused_naming_what_is_at_fault(service, body, told, place):
    before = left_behind(service)
    answer = service.request("POST", "/v1/sweeps", json=body)
    assert_problem(answer, 422, told)
    if place is not None:
        assert answer.json()["errors"][0]["location"] == place
    assert left_behind(service) == before


def test_a_basin_request_varies_nothing(service):
    assert_problem(service.request("POST", "/v1/basins", json=vary(DAMPING)), 422, "body.vary: Extra inputs")


@pytest.mark.slow
def test_a_killed_service_resumes_its_sweep_at_the_next_start(tmp_path):
    count = {"parameter": "damping", "start": 0.55, "stop": 0.65, "count": 12}
    body = REQUEST | {"vary": [count], "grid": {"time": {"cells": 60}, "velocity": {"cells": 60}}}
    with running_service(tmp_path) as first:
        job = submitted(first, body)
        first.wait(job["id"], lambda job: job["progress"] and job["progress"]["basins_done"] >= 1)
        first.kill()
    with running_service(tmp_path) as second:
        done = second.wait(job["id"])
        assert done["state"] == "succeeded" and done["progress"]["basins_done"] == 12
