"""What the explorer draws a basin from, over HTTP."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from rattle_kernels import uncertainty_exponent
from rattle_paper.papers_oscillator import papers_oscillator
from tests.service.routes.problems import STIFF, assert_problem
from worker.jobs.basin_job import basin_job
from worker.results.opening import open_basin

EXPLORER = Path(__file__).parents[3] / "service" / "explorer"
SMALL = {"grid": {"time": {"cells": 130}, "velocity": {"cells": 130}}, "iterations": 179}


@pytest.fixture(scope="module")
def finished(service):
    return service.wait(service.submit(SMALL)["id"])


def outline(service, job, basin=0):
    return service.request("GET", f"/v1/jobs/{job['id']}/outline?panel={basin}").json()


def tile(service, job, number, every=1):
    """Labels of a tile by name, as a viewer reads them."""
    answer = service.request("GET", f"/v1/jobs/{job['id']}/tiles/{number}?every={every}")
    assert answer.status_code == 200, answer.text
    rows, columns = map(int, answer.headers["rattle-shape"].split())
    cells = rows * columns
    wide = np.frombuffer(answer.content, "<i4", 3 * cells).reshape(3, rows, columns)
    solution = np.frombuffer(answer.content, "<i2", cells, 12 * cells).reshape(rows, columns)
    return dict(zip(("step", "group", "period"), wide, strict=True)) | {"solution": solution}


def test_the_uncertainty_exponent_of_a_window_is_that_of_its_labels(service, finished):
    told = service.request("GET", f"/v1/jobs/{finished['id']}/uncertainty").json()
    with open_basin(service.store_of(finished)) as basin:
        fit = uncertainty_exponent(basin.solution.values, wraps=True)
    assert told == pytest.approx({"exponent": fit.exponent, "error": fit.error})
    assert 0.0 < fit.exponent < 1.0


def test_too_few_cells_have_no_uncertainty_exponent(service):
    job = service.wait(
        service.submit({"grid": {"time": {"cells": 32}, "velocity": {"cells": 60}}, "iterations": 61})["id"]
    )
    assert_problem(service.request("GET", f"/v1/jobs/{job['id']}/uncertainty"), 422, "33 x 33 cells at least")


@pytest.mark.parametrize("every", [1, 3])
def test_the_tiles_together_are_the_store(service, finished, every):
    told = outline(service, finished)["tiles"]
    assert told["down"] * told["across"] > 1
    rows = [
        [tile(service, finished, row * told["across"] + column, every) for column in range(told["across"])]
        for row in range(told["down"])
    ]
    with open_basin(service.store_of(finished)) as basin:
        for name in ("step", "group", "period", "solution"):
            whole = np.block([[labels[name] for labels in row] for row in rows])
            np.testing.assert_array_equal(whole, basin[name].values[::every, ::every])


def test_the_outline_says_what_is_there_and_how_it_is_drawn(service, finished):
    told = outline(service, finished)
    assert told["complete"] and set(told["tiles"]["states"]) == {3}
    solutions = {solution["name"]: solution for solution in told["solutions"]}
    assert solutions["permanent contact"]["colours"]["paper"] == "#000080"
    assert solutions["P(1,1,0)"]["points"][0][1] == pytest.approx(1.2 * np.pi)
    assert sum(solution["share"] for solution in told["solutions"]) == pytest.approx(1.0)
    assert 100 < len(solutions["chaotic"]["points"]) <= 3000
    for palette in ("paper", "colour_blind"):
        assert len({solution["colours"][palette] for solution in told["solutions"]}) == 3
    assert len(told["grazing"]["time"]) == len(told["grazing"]["velocity"]) > 100


def test_a_tile_that_is_known_is_not_sent_again(service, finished):
    path = f"/v1/jobs/{finished['id']}/tiles/0"
    first = service.request("GET", path)
    assert "immutable" in first.headers["cache-control"] and first.headers["content-encoding"] == "gzip"
    again = service.request("GET", path, headers={"if-none-match": first.headers["etag"]})
    assert again.status_code == 304 and again.content == b""
    plain = service.request("GET", path, headers={"accept-encoding": "identity"})
    assert plain.content == first.content and "content-encoding" not in plain.headers


def test_tiles_and_panels_that_are_not_there_are_told_so(service, finished):
    there = f"/v1/jobs/{finished['id']}"
    assert_problem(service.request("GET", f"{there}/tiles/999"), 404, "none of this number")
    assert_problem(service.request("GET", f"{there}/outline?panel=1"), 422, "basin 1 is none of the job's 1")
    assert_problem(service.request("GET", "/v1/jobs/nothing/outline"), 404, "no job nothing")


def test_a_sample_has_no_tiles(service):
    body = {"iterations": 101, "sample": {"points": 64}}
    job = service.wait(service.submit(body)["id"])
    assert_problem(service.request("GET", f"/v1/jobs/{job['id']}/outline"), 422, "a sample has no cells")


def test_a_panel_of_a_sweep_has_its_own_outline_and_tiles(service):
    body = {
        "oscillator": {"eccentricity": 0.1}, "vary": [{"parameter": "damping", "values": [0.55, 0.6]}],
        "grid": {"time": {"cells": 20}, "velocity": {"cells": 20}}, "iterations": 101,
    }  # fmt: skip
    job = service.wait(service.request("POST", "/v1/sweeps", json=body).json()["id"])
    first, second = outline(service, job), outline(service, job, 1)
    assert (first["parameters"], second["parameters"]) == ({"damping": 0.55}, {"damping": 0.6})
    names = [solution["name"] for solution in first["solutions"]]
    assert names == [solution["name"] for solution in second["solutions"]]
    assert second["tiles"]["first"] == 1
    with open_basin(service.store_of(job)) as sweep:
        np.testing.assert_array_equal(tile(service, job, 1)["solution"], sweep.solution.values[1])


def test_overlays_are_those_of_the_pictures(service, finished):
    def overlays(kind):
        return service.request("GET", f"/v1/jobs/{finished['id']}/overlays/{kind}").json()["overlays"]

    first, second = overlays("preimages")
    assert (first["label"], first["colour"], second["colour"]) == ("pre-image 1 of grazing", "black", "yellow")
    assert first["marker"] is None and len(first["pieces"][0]["time"]) == len(first["pieces"][0]["velocity"]) > 10
    marks = {mark["label"]: mark for mark in overlays("attractors")}
    assert marks["P(1,1,0)"]["marker"] == "x"
    assert_problem(service.request("GET", f"/v1/jobs/{finished['id']}/overlays/frame"), 422, "preimages")


def test_the_page_comes_with_a_policy_that_lets_nothing_else_in(service):
    page = service.request("GET", "/")
    assert page.status_code == 200 and page.headers["content-type"].startswith("text/html")
    policy = page.headers["content-security-policy"]
    assert "default-src 'self'" in policy and "unsafe" not in policy and "http" not in policy
    linked = re.findall(r'(?:src|href)="(explorer/[^"]+)"', page.text)
    # All modules are asked for at once, not one level of imports after another.
    modules = {f"explorer/{path.relative_to(EXPLORER)}" for path in (EXPLORER / "js").rglob("*.js")}
    assert set(linked) == modules | {"explorer/icon.svg", "explorer/explorer.css"}
    for path in linked:
        assert service.request("GET", f"/{path}").status_code == 200


def test_every_example_of_the_page_is_a_request_of_the_paper(service):
    presets = {preset["name"]: preset for preset in service.request("GET", "/explorer/presets.json").json()}
    jobs = {name: basin_job(preset["request"]) for name, preset in presets.items()}
    for name, stiffness in {"fig6a": 1e2, "fig6d": 1e5, "fig7top": 1e6, "fig7bottom": math.inf}.items():
        assert jobs[name].oscillator == papers_oscillator(stiffness) and jobs[name].iterations == 1499
    assert [job.basins for job in (jobs["fig8"], jobs["fig9"])] == [9, 9]
    assert jobs["fig12"].oscillator.damping == 0.527 and jobs["fig13b"].oscillator.damping == 0.5922


def check(service, **body):
    answer = service.request("POST", "/v1/checks", json=body)
    assert answer.status_code == 200, answer.text
    return answer.json()


def test_a_check_accepts_what_a_submission_would_and_records_nothing(service):
    before = service.request("GET", "/v1/jobs").json()
    told = check(service, **SMALL)
    assert told["accepted"] and told["errors"] == [] and told["applications"] == 130 * 130 * 179
    assert service.request("GET", "/v1/jobs").json() == before


@pytest.mark.parametrize(
    "body",
    [
        {"oscillator": STIFF | {"stiffness": 0.01}},
        {"oscillator": {"damping": -1}},
        {"oscillator": {"model": "piecewise_linear", "stiffness": 100, "eccentricity": 0.16}},
        {"oscillator": {"model": "spring"}},
        {"iterations": 10},
        {"grid": {"time": {"start": 0.5, "stop": 0.4}}},
        {"grid": {"time": {"cells": 100_000}, "velocity": {"cells": 100_000}}},
        {"unknown": 1},
        {
            "vary": [{"parameter": "damping", "values": [0.6, 0.3]}],
            "oscillator": STIFF | {"allow_no_quiet_solution": False},
        },
    ],
)
def test_a_check_refuses_in_the_words_of_the_submission(service, body):
    told = check(service, **body)
    path = "/v1/sweeps" if "vary" in body else "/v1/basins"
    refused = service.request("POST", path, json=body).json()
    assert not told["accepted"] and refused["status"] == 422
    assert told["errors"][0]["message"] in refused["detail"]
    if refused["errors"]:
        assert told["errors"] == refused["errors"]


def test_bounds_follow_the_other_parameters_whatever_else_is_wrong(service):
    def bounds(**oscillator):
        return {bound["field"]: bound for bound in check(service, oscillator=oscillator)["bounds"]}

    loose = bounds(damping=0.6, eccentricity=9)["eccentricity"]
    assert loose["loose_from"] == pytest.approx(0.19012, abs=1e-5) and loose["below"] is None
    stiff = {"model": "piecewise_linear", "damping": 0.6, "stiffness": 100}
    assert bounds(**stiff)["eccentricity"]["below"] == pytest.approx(0.15263, abs=1e-5)
    assert "Eq. 3" in bounds(**stiff)["eccentricity"]["why"]
    wider = bounds(**stiff, allow_no_quiet_solution=True)["eccentricity"]
    assert wider["loose_from"] == pytest.approx(0.19012, abs=1e-5) and wider["below"] is None
    assert bounds(**stiff)["stiffness"]["above"] == pytest.approx(0.045)
    assert bounds(damping="much")["eccentricity"]["loose_from"] == pytest.approx(0.19012, abs=1e-5)


def test_bounds_of_damping_and_stiffness_are_where_the_service_refuses(service):
    stiff = {"model": "piecewise_linear", "damping": 0.6, "eccentricity": 0.1, "stiffness": 1e4}
    bounds = {bound["field"]: bound for bound in check(service, oscillator=stiff)["bounds"]}
    above, (low, high) = bounds["damping"]["above"], bounds["stiffness"]["between"]
    assert above == pytest.approx(0.3152, abs=1e-4)
    edges = [({"damping": above}, True), ({"stiffness": low}, False), ({"stiffness": high}, True)]
    for changed, accepted_beyond in edges:
        ((name, edge),) = changed.items()
        for value, beyond in ((edge * 0.999, False), (edge * 1.001, True)):
            told = check(service, oscillator=stiff | {name: value})
            assert told["accepted"] == (accepted_beyond == beyond), (name, value)
    allowed = check(service, oscillator=stiff | {"allow_no_quiet_solution": True})["bounds"]
    assert [bound["above"] for bound in allowed if bound["field"] == "damping"] == [0.0]
    # A second harmonic moves the bound, and is not looked at here.
    harmonics = [{"order": 2, "amplitude": 0.01}]
    assert "eccentricity" not in [
        each["field"] for each in check(service, oscillator={"harmonics": harmonics})["bounds"]
    ]


def test_a_number_of_iterations_that_is_no_prime_is_named(service):
    assert check(service, iterations=1500)["errors"][0]["location"] == ["body", "iterations"]


def test_a_history_says_from_which_contact_on_it_is_permanent(service):
    start = {"time": 0.2, "velocity": 1.0}
    told = service.request("POST", "/v1/trajectories", json={"start": start, "periods": 10}).json()
    assert told["outcome"] == "permanent_contact"
    times = [0.2, *(contact["time"] for contact in told["contacts"])]
    assert told["permanent_from"] in times
    rattles = service.request("POST", "/v1/trajectories", json={"start": {"time": 0.1, "velocity": 6.5}}).json()
    assert rattles["permanent_from"] is None
