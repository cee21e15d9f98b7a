"""Who may change a job, tried at every route that changes one: the table comes from the application's own routes."""

import time

import pytest
from fastapi.routing import iter_route_contexts

from service.records import keys as keys_module
from service.records.job_record import JobState
from service.records.keys import Keys, KeyScope
from service.routes import jobs as job_routes
from tests.service.idle_service import idle_service

READING = {"GET", "HEAD", "OPTIONS"}
BODY = {"grid": {"time": {"cells": 4}, "velocity": {"cells": 4}}, "iterations": 1}


@pytest.fixture(scope="module")
def service(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(keys_module, "_REFRESH_SECONDS", 0.05)
        patch.setattr(job_routes, "_LEAVING_SECONDS", 0.0)
        with idle_service(patch, tmp_path_factory.mktemp("idle"), require_keys=True) as service:
            yield service


@pytest.fixture(scope="module")
def keys(service):
    """A key of the owner, and of each caller that is less than an owner or more."""
    ring = Keys(service.jobs._sessions)
    scopes = {
        "owner": [KeyScope.READ, KeyScope.SUBMIT],
        "another": [KeyScope.READ, KeyScope.SUBMIT],
        "submitter": [KeyScope.SUBMIT],
        "reader": [KeyScope.READ],
        "admin": [KeyScope.ADMIN],
    }
    made = {name: ring.add(name, each) for name, each in scopes.items()}
    made["owner who reads"] = ring.add("owner", [KeyScope.READ])
    time.sleep(0.1)
    return made


def changing(service):
    """Method and path of every route that may change something."""
    return sorted(
        (method, route.path)
        for route in iter_route_contexts(service.app.routes)
        for method in (route.methods or set()) - READING
    )


def asked(service, method, path, job_id, key):
    headers = {} if key is None else {"authorization": f"Bearer {key}"}
    return service.request(method, path.replace("{job_id}", job_id), headers=headers, json=None)


def test_a_job_is_changed_by_its_owner_and_by_administrators_alone(service, keys):
    routes = [(method, path) for method, path in changing(service) if "{job_id}" in path]
    assert {path.rpartition("/")[2] for _, path in routes} >= {"cancel", "withdraw", "{job_id}"}
    refusals = {
        None: (401, "key-required"), "another": (403, "not-yours"), "submitter": (403, "not-yours"),
        "reader": (403, "scope-missing"), "owner who reads": (403, "scope-missing"),
    }  # fmt: skip
    for cells, (method, path) in enumerate(routes, 4):
        job = service.add_job(cells, "owner")
        for name, (status, kind) in refusals.items():
            answer = asked(service, method, path, job.id, keys.get(name))
            assert (answer.status_code, answer.json()["type"]) == (status, f"/problems/{kind}"), (method, path, name)
            left = service.jobs.get(job.id)
            assert (left.state, left.store) == (JobState.QUEUED, job.store), (method, path, name)
        for name in ("owner", "admin"):
            job = service.add_job(cells, "owner")
            answer = asked(service, method, path, job.id, keys[name])
            assert answer.status_code in (200, 202, 204), (method, path, name, answer.text)


def test_nothing_is_submitted_by_who_may_only_read(service, keys):
    routes = [(method, path) for method, path in changing(service) if "{job_id}" not in path]
    assert {("POST", "/v1/basins"), ("POST", "/v1/previews"), ("POST", "/v1/checks")} <= set(routes)
    before = service.jobs.count()
    for method, path in routes:
        headers = {"authorization": f"Bearer {keys['reader']}"}
        answer = service.request(method, path, headers=headers, json=BODY)
        assert (answer.status_code, answer.json()["type"]) == (403, "/problems/scope-missing"), path
        assert service.request(method, path, json=BODY).status_code == 401
    assert service.jobs.count() == before
