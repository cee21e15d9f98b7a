"""One time history over HTTP, answered at once."""

import numpy as np
import pytest

from rattle_kernels import Oscillator, Outcome, time_history
from tests.rattle_kernels.reference import entries
from tests.service.routes.problems import assert_problem

STIFF = {"model": "piecewise_linear", "stiffness": 100}
START = {"time": 0.3, "velocity": 4}


def ask(service, **body):
    return service.request("POST", "/v1/trajectories", json=body)


@pytest.mark.parametrize("stiffness", [None, 100.0])
def test_the_answer_is_the_history_of_the_kernels(service, stiffness):
    oscillator = {} if stiffness is None else {"model": "piecewise_linear", "stiffness": stiffness}
    answer = ask(service, oscillator=oscillator, start=START, periods=7.5, samples_per_period=50)
    assert answer.status_code == 200, answer.text
    told = answer.json()
    history = time_history(
        Oscillator() if stiffness is None else Oscillator(stiffness=stiffness), 0.3, 0.6, -4.0, periods=7.5,
        samples_per_period=50,
    )  # fmt: skip
    for name in ("time", "displacement", "velocity"):
        np.testing.assert_array_equal(told[name], getattr(history, name))
    assert [contact["time"] for contact in told["contacts"]] == history.contacts.time.tolist()
    assert [contact["wall"] for contact in told["contacts"]] == history.contacts.wall.tolist()
    directions = {contact["direction"] for contact in told["contacts"]}
    assert directions == ({"impact"} if stiffness is None else {"in", "out"})
    assert told["outcome"] == "rattling" and history.outcome == Outcome.RETURNED and told["truncated"] is False


def test_the_defaults_are_the_papers(service):
    told = ask(service, start=START).json()
    assert told["time"][0] == 0.3 and told["time"][-1] == 20.3 and len(told["time"]) > 4000


def test_a_start_may_be_anywhere(service):
    inside = ask(service, oscillator=STIFF, start={"time": -2, "displacement": 0.7, "velocity": 0}, periods=1).json()
    assert inside["displacement"][0] == 0.7 and inside["time"][0] == -2
    beyond = ask(service, start={"time": 0, "displacement": 0.7, "velocity": 0})
    assert_problem(beyond, 422, "within the backlash, at most 0.6 either way")


def test_low_bounces_end_as_permanent_contact_and_too_many_contacts_truncate(service):
    low = ask(service, start={"velocity": 0.1}, periods=3).json()
    assert low["outcome"] == "permanent_contact" and not low["truncated"]
    lower = ask(service, start={"velocity": 0.001}, periods=30, samples_per_period=1).json()
    assert lower["truncated"] and len(lower["contacts"]) == 20_000
    assert lower["time"][-1] == lower["contacts"][-1]["time"] < 30


def test_beyond_the_bound_of_the_quiet_solution_only_where_that_is_allowed(service):
    oscillator = STIFF | {"eccentricity": 0.16}
    refused = ask(service, oscillator=oscillator, start=START)
    assert_problem(refused, 422, "below epsilon_crit1 = 0.15263")
    assert "allow_no_quiet_solution" in refused.json()["detail"]
    assert refused.json()["errors"][0]["location"] == ["body", "oscillator", "eccentricity"]
    assert ask(service, oscillator=oscillator | {"allow_no_quiet_solution": True}, start=START).status_code == 200
    beyond = oscillator | {"eccentricity": 0.2, "allow_no_quiet_solution": True}
    assert ask(service, oscillator=beyond, start=START).status_code == 200


@pytest.mark.parametrize(("rule", "outcome"), [("envelope", "rattling"), ("one_rotation", "permanent_contact")])
def test_the_papers_rule_calls_a_long_contact_permanent(service, rule, outcome):
    entry = next(entry for entry in entries("map_pwl.json") if entry["category"] == "rule_differs")
    names = {"damping": "delta", "eccentricity": "eps", "half_backlash": "beta", "stiffness": "kappa"}
    oscillator = STIFF | {name: float(entry[symbol]) for name, symbol in names.items()} | {"permanent_contact": rule}
    start = {"time": float(entry["t0"]), "velocity": float(entry["v0"])}
    told = ask(service, oscillator=oscillator, start=start, periods=float(entry["tau"]) + 1e-3).json()
    assert told["outcome"] == outcome
    assert [contact["direction"] for contact in told["contacts"]] == ["in", "out"]


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ({}, "body.start: Field required"),
        ({"start": {"time": 0.3}}, "body.start.velocity: Field required"),
        ({"start": {"velocity": 0}}, "velocity must be positive"),
        ({"start": {"velocity": -2}}, "without a displacement it is the speed"),
        ({"start": {"velocity": 1e9}}, "less than or equal to 1000000"),
        ({"start": {"velocity": "fast"}}, "body.start.velocity: Input should be a valid number"),
        ({"start": {"velocity": True}}, "valid number"),
        ({"start": START | {"phase": 0.1}}, "body.start.phase: Extra inputs"),
        ({"start": START, "periods": 0}, "body.periods: Input should be greater than 0"),
        ({"start": START, "periods": 1e-30, "samples_per_period": 10**20}, "less than or equal to 1000000"),
        ({"start": START, "periods": 501}, "100200 samples (periods times samples_per_period) are more than the limit"),
        ({"start": START, "samples_per_period": 10**6}, "limit of 100000"),
        ({"start": START, "samples_per_period": 0}, "greater than or equal to 1"),
        ({"start": START, "oscillator": STIFF | {"stiffness": 0}}, "oscillator.stiffness: Input should be greater"),
        ({"start": START, "oscillator": STIFF | {"stiffness": -5}}, "greater than 0"),
        ({"start": START, "oscillator": STIFF | {"stiffness": None}}, "valid number"),
        ({"start": START, "oscillator": STIFF | {"stiffness": 1e13}}, "less than or equal to 1000000000000"),
        ({"start": START, "oscillator": STIFF | {"stiffness": 0.01}}, "stiffness must be above damping^2/8 = 0.045"),
        ({"start": START, "oscillator": {"model": "piecewise_linear"}}, "stiffness: Field required"),
        ({"start": START, "oscillator": {"stiffness": 100}}, "stiffness belongs to the piecewise linear model"),
        ({"start": START, "oscillator": STIFF | {"permanent_contact": "soon"}}, "'envelope' or 'one_rotation'"),
        ({"start": START, "oscillator": STIFF | {"allow_no_quiet_solution": 1}}, "valid boolean"),
        ({"start": START, "oscillator": {"model": "soft"}}, "whose model is"),
    ],
    ids=lambda part: str(part)[:60],
)  # fmt: skip
def test_a_wrong_request_is_refused(service, body, told):
    assert_problem(ask(service, **body), 422, told)


@pytest.mark.parametrize("stiffness", ["NaN", "Infinity", "-Infinity", "1e400"])
def test_a_stiffness_that_json_should_not_carry_is_refused(service, stiffness):
    content = f'{{"oscillator": {{"model": "piecewise_linear", "stiffness": {stiffness}}}, "start": {{"velocity": 1}}}}'
    headers = {"content-type": "application/json"}
    answer = service.request("POST", "/v1/trajectories", content=content, headers=headers)
    assert_problem(answer, 422, "body.oscillator.stiffness: Input should be a finite number")


def test_a_query_asks_what_the_motion_does_in_the_end(service):
    body = {"start": {"time": 0.0233, "velocity": 2.584}, "periods": 15, "samples_per_period": 1}
    told = service.request("POST", "/v1/trajectories?end=true", json=body).json()
    assert told["end"]["kind"] == "permanent_contact" and told["end"]["first"] is None
    assert told["end"]["periods"] == pytest.approx(told["permanent_from"] - 0.0233)
    assert "end" not in service.request("POST", "/v1/trajectories", json=body).json()
    rattles = service.request(
        "POST", "/v1/trajectories?end=true", json=body | {"start": {"time": 0.93, "velocity": 5.2}}
    )
    assert rattles.json()["end"] | {"impacts": 0} == {
        "kind": "rattling", "name": None, "periods": 1000.0, "impacts": 0, "first": None
    }  # fmt: skip
