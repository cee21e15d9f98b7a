"""Diagrams, orbits, manifolds, curves, reports and charts over HTTP, as a client sees them, and what is refused."""

import json

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from rattle.cli import app
from tests.analysis_requests import ROUTES
from tests.service.routes.problems import STIFF, assert_problem, left_behind


def submitted(service, route, body):
    answer = service.request("POST", f"/v1/{route}", json=body)
    assert answer.status_code == 202, answer.text
    return answer.json()


@pytest.fixture(scope="module")
def finished(service):
    """All of these kinds, computed one after another: the job and the result of each, by its route."""
    ids = {route: submitted(service, route, body)["id"] for route, body in ROUTES.items()}
    jobs = {route: service.wait(job_id) for route, job_id in ids.items()}
    for job in jobs.values():
        assert job["state"] == "succeeded", job
    return {route: (job, service.request("GET", job["links"]["result"]).json()) for route, job in jobs.items()}


@pytest.mark.parametrize("route", ROUTES)
def test_an_analysis_is_a_job_like_any_other(service, finished, route):
    job, result = finished[route]
    assert job["kind"] == result["kind"] == job["request"]["kind"] and result["complete"]
    assert job["progress"]["stage"] == "done"
    assert job["progress"]["tiles_done"] == job["progress"]["tiles_total"] > 0
    again = submitted(service, route, job["request"])
    assert again["id"] == job["id"], "the request that a job shows asks for that job"
    picture = service.request("GET", job["links"]["picture"])
    assert picture.content.startswith(b"\x89PNG")


@pytest.mark.parametrize("route", ROUTES)
def test_its_store_opens_by_its_address_with_named_dimensions(service, finished, route):
    job, result = finished[route]
    with xr.open_zarr(service.url + job["links"]["zarr"]) as store:
        assert store.attrs["complete"] and store.attrs["kind"] == job["kind"] and store.attrs["finished"]
        assert store.attrs["versions"].keys() >= {"gear-rattle", "numpy", "numba"}
        assert not any(str(name).startswith("dim_") for name in store.dims)
        assert all(store[name].attrs["long_name"] for name in store.variables)


def test_a_diagram_tells_where_motions_change(service, finished):
    job, result = finished["bifurcations"]
    small, large = result["motions"]
    assert result["values_visited"] == 22
    # Its saddle-node lies at 0.59972: the last value is beyond it, and there the motion falls quiet.
    assert [(run["what"], run["way"], run["values"]) for run in small["stretches"]] == [
        ("impact period 2", "up", 10),
        ("permanent contact", "up", 1),
        ("permanent contact", "down", 11),
    ]
    assert [run["what"] for run in large["stretches"]] == ["impact period 1"] * 2
    with xr.open_zarr(service.url + job["links"]["zarr"]) as store:
        assert store.velocity.dims == store.time.dims == ("visit", "seed", "kept")
        speeds = store.velocity[:, 1].values
        np.testing.assert_allclose(speeds, np.repeat(2 * np.pi * store.damping.values[:, None], 20, axis=1), rtol=1e-12)


def test_orbits_are_told_to_ten_digits_with_branches_and_special_points(finished):
    _, result = finished["orbits"]
    names = [(orbit["name"], orbit["attracts"]) for orbit in result["orbits"]]
    assert {("P(1,1,0)", True), ("P(1,1,0)", False), ("P(1,2,0)", True), ("P(1,2,0)", False)} <= set(names)
    for orbit in result["orbits"]:
        product = np.prod([complex(*pair) for pair in orbit["multipliers"]])
        assert product == pytest.approx(np.exp(-0.575 * orbit["forcing_periods"]), rel=1e-9)
        assert orbit["residual"] < 1e-11 and len(orbit["departures"]) == orbit["upper_contacts"]
    saddle_nodes = [point for point in result["special_points"] if point["kind"] == "saddle-node"]
    assert [point["value"] for point in saddle_nodes] == [pytest.approx(0.5997157625984, abs=1e-11)]
    # Node and saddle are joined by the fold: one branch, which comes back to the bound that it came from.
    joined = result["branches"][saddle_nodes[0]["branch"]]
    own = [orbit["name"] for orbit in result["orbits"] if orbit["branch"] == saddle_nodes[0]["branch"]]
    assert own == ["P(1,2,0)", "P(1,2,0)"]
    assert [end["reason"] for end in joined["ends"]] == ["bound", "bound"] and joined["lowest"] == 0.55


def test_manifolds_are_told_with_their_lengths_and_ends(service, finished):
    job, result = finished["manifolds"]
    assert [saddle["name"] for saddle in result["saddles"]] == ["P(1,1,0)"]
    kinds = [(branch["manifold"], branch["side"]) for branch in result["branches"]]
    assert kinds == [("stable", 1), ("stable", -1), ("unstable", 1), ("unstable", -1)]
    ends = [branch["end"] for branch in result["branches"]]
    assert "faster than asked for" in ends[0] and ends[1] == "it is as long as asked for"
    assert result["branches"][1]["arclength"] == pytest.approx(3.0)
    with xr.open_zarr(service.url + job["links"]["zarr"]) as store:
        assert int(store.piece_size.sum()) == store.sizes["vertex"] == store.time.size
        assert int(store.branch_size.sum()) == store.sizes["piece"]
        assert float(store.velocity.max()) <= 7.0


def test_pre_images_are_told_order_by_order(finished):
    _, result = finished["grazing-curves"]
    assert [(order["order"], order["pieces"], order["complete"]) for order in result["orders"]][0] == (0, 1, True)
    assert len(result["orders"]) == 2 and result["orders"][1]["arclength"] > result["orders"][0]["arclength"]


@pytest.mark.parametrize("route", ROUTES)
def test_a_shell_submits_every_kind_and_prints_what_was_found(service, finished, tmp_path, route):
    job, _ = finished[route]
    request = tmp_path / "request.json"
    request.write_text(json.dumps(job["request"]))
    command = ["submit", str(request), "--wait", "--url", service.url]
    answer = CliRunner().invoke(app, command)
    assert answer.exit_code == 0, answer.output
    told = {"bifurcations": "permanent contact", "orbits": "0.59971576259", "manifolds": "3.7699111843"}
    told |= {"reports": "the machine can run quietly", "charts": "saddle-node and graze"}
    assert job["id"] in answer.output and told.get(route, "vertices") in answer.output


@pytest.mark.parametrize(
    ("saddle", "told"),
    [
        ({"time": 0.9, "velocity": 3.77}, "is a focus"),
        ({"time": 0.2, "velocity": 6.9, "period": 2}, "found no periodic orbit"),
    ],
)
def test_what_is_no_saddle_is_said_by_the_job_that_fails(service, saddle, told):
    job = service.wait(submitted(service, "manifolds", {"saddles": [saddle]})["id"])
    assert job["state"] == "failed" and job["error"]["kind"] == "nothing-found", job
    assert "saddle 1: " in job["error"]["detail"] and told in job["error"]["detail"]


@pytest.mark.parametrize(
    ("route", "change", "told"),
    [
        ("bifurcations", {"seeds": [{"time": 0.1, "velocity": -3}]}, "section of departures from +beta"),
        ("bifurcations", {"seeds": []}, "at least 1 item"),
        (
            "bifurcations",
            {
                "oscillator": STIFF | {"allow_no_quiet_solution": False},
                "vary": {"parameter": "damping", "values": [0.6, 0.2]},
            },
            "epsilon_crit1",
        ),
        ("bifurcations", {"vary": {"parameter": "damping", "values": [0.6, 0.6]}}, "must ascend"),
        ("bifurcations", {"vary": {"parameter": "colour", "values": [1]}}, "body.vary.parameter"),
        ("bifurcations", {"region": {}}, "not both"),
        ("bifurcations", {"kept": 0}, "body.kept"),
        ("bifurcations", {"transient": 10**10}, "RATTLE_MAX_DIAGRAM_APPLICATIONS"),
        ("bifurcations", {"direction": "sideways"}, "'up', 'down' or 'both'"),
        ("orbits", {"seeds": [{"time": 0, "velocity": 1}]}, "not both: leave out longest"),
        ("orbits", {"longest": 0}, "body.longest"),
        ("orbits", {"cells": 10**6}, "RATTLE_MAX_ORBIT_STARTS"),
        ("orbits", {"region": {"velocity": {"start": 3, "stop": 2}}}, "must ascend"),
        ("orbits", {"continuation": {"parameter": "damping", "start": 0.6, "stop": 0.7}}, "hold its value 0.575"),
        ("orbits", {"curves": {"parameter": "damping", "start": 0, "stop": 1}}, "another than the first"),
        ("orbits", {"continuation": None, "curves": {"parameter": "damping", "start": 0, "stop": 1}}, "continuation"),
        ("manifolds", {"saddles": []}, "at least 1 item"),
        ("manifolds", {"saddles": [{"time": 0.6}]}, '{"itinerary": "P(1,1,0)"}'),
        ("manifolds", {"saddles": [{"time": 0.6, "velocity": 3.77, "period": 0}]}, "period must be 1 or more"),
        ("manifolds", {"saddles": [{"time": 0.6, "velocity": 0}]}, "section of departures from +beta"),
        ("manifolds", {"saddles": [{"itinerary": "P(1,1)"}]}, "an itinerary is P(m, n+, n-)"),
        ("manifolds", {"arclength": 1e9}, "RATTLE_MAX_ARCLENGTH"),
        ("manifolds", {"arclength": None}, "body.arclength"),
        ("manifolds", {"arclength": 0}, "arclength must be above 0"),
        ("manifolds", {"oscillator": {"model": "piecewise_linear", "stiffness": 100}}, "the inverse of P is needed"),
        ("grazing-curves", {"order": -1}, "order must be 0"),
        ("grazing-curves", {"order": 99}, "RATTLE_MAX_ORDER"),
        ("grazing-curves", {"velocity": {"start": 5, "stop": 5}}, "speeds must ascend"),
        ("grazing-curves", {"resolution": {"chord": -1}}, "chord must be positive"),
        ("grazing-curves", {"kind": "orbits"}, "body.kind"),
    ],
)
def test_what_cannot_be_asked_is_refused(service, route, change, told):
    before = left_behind(service)
    assert_problem(service.request("POST", f"/v1/{route}", json=ROUTES[route] | change), 422, told)
    assert left_behind(service) == before


def test_an_arclength_without_bound_is_refused(service):
    body = '{"saddles": [{"time": 0.6, "velocity": 3.77}], "arclength": Infinity}'
    answer = service.request("POST", "/v1/manifolds", content=body, headers={"content-type": "application/json"})
    assert_problem(answer, 422, "body.arclength: Input should be a finite number")


def test_a_diagram_without_seeds_starts_from_the_attractors_it_finds(service):
    vary = {"parameter": "damping", "values": [0.6]}
    job = service.wait(submitted(service, "bifurcations", {"vary": vary, "transient": 200})["id"])
    assert job["state"] == "succeeded", job
    motions = service.request("GET", job["links"]["result"]).json()["motions"]
    assert [motion["name"] for motion in motions] == ["P(1,1,0)", "chaotic"]
    quiet = {"vary": {"parameter": "damping", "values": [0.75]}}
    job = service.wait(submitted(service, "bifurcations", quiet)["id"])
    assert job["state"] == "failed" and "give seeds, another region" in job["error"]["detail"]
