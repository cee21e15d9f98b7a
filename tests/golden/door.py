"""What is sent to a service, and what is kept of its answers."""

import json

from tests.golden.adapter import stored

VARIES = {"created", "started", "finished", "seconds", "seconds_left", "cells_per_second"}
"""Fields of answers that tell of times."""


def post(service, case):
    """Answer to a case's body."""
    return service.request("POST", f"/v1/{case['route']}", json=case["body"])


def submitted(service, case):
    """Job that a case asks for."""
    answer = post(service, case)
    assert answer.status_code == 202, answer.text
    return answer.json()


def stored_request(service, data, case):
    """The case with what the service stores of it."""
    job = submitted(service, case)
    return asked(case) | stored(data, job["id"])


def refusal(service, case):
    """The case with the structure of the refusal, without its words."""
    answer = post(service, case)
    problem = answer.json()
    places = [error["location"] for error in problem["errors"]]
    kept = {"status": answer.status_code, "type": problem["type"], "locations": places, "keys": sorted(problem)}
    return asked(case) | kept


def asked(case):
    """What a case asks, without what was answered."""
    return {name: case[name] for name in ("name", "route", "body") if name in case}


def trajectory(service, case):
    """The case with the answer to it."""
    answer = service.request("POST", "/v1/trajectories", json=case["body"])
    return asked(case) | {"answer": answer.json()}


def steady(answer, job_id):
    """An answer without times, and with ID for the job's id."""
    return _without_times(json.loads(json.dumps(answer).replace(job_id, "ID")))


def _without_times(value):
    if isinstance(value, list):
        return [_without_times(each) for each in value]
    if isinstance(value, dict):
        return {name: _without_times(each) for name, each in value.items() if name not in VARIES}
    return value
