"""A job that nobody follows is dropped; one that somebody follows goes on."""

import httpx2 as httpx

LONG = {"grid": {"time": {"cells": 1500}, "velocity": {"cells": 1500}}, "iterations": 15101}


def withdraw(service, job):
    return service.request("POST", f"/v1/jobs/{job['id']}/withdraw")


def test_a_job_that_nobody_follows_is_stopped(service):
    job = service.submit(LONG)
    assert withdraw(service, job).status_code == 204
    assert service.wait(job["id"])["state"] == "cancelled"
    assert withdraw(service, job).status_code == 204, "once more changes nothing"


def test_a_job_that_somebody_follows_goes_on_until_they_leave(service):
    job = service.submit(LONG | {"iterations": 15107})
    with httpx.stream("GET", service.url + job["links"]["events"], timeout=30.0) as events:
        lines = events.iter_lines()  # kept, since an iterator that is thrown away closes the stream
        next(lines)
        assert withdraw(service, job).status_code == 204
        assert service.request("GET", job["links"]["self"]).json()["state"] in ("queued", "running")
    assert withdraw(service, job).status_code == 204
    assert service.wait(job["id"])["state"] == "cancelled"


def test_a_job_that_is_not_there_is_a_problem(service):
    assert service.request("POST", f"/v1/jobs/{'0' * 32}/withdraw").status_code == 404
