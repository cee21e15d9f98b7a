"""Checks of refused requests: the problem document, and that nothing is left behind."""

# Of finite stiffness, machines beyond the bound of Eq. (8) are refused.
STIFF = {"model": "piecewise_linear", "stiffness": 1e4, "allow_no_quiet_solution": True}


def left_behind(service):
    """Everything that a refused request could have left."""
    jobs = service.request("GET", "/v1/jobs?size=200").json()["jobs"]
    results = service.data / "results"
    return [job["id"] for job in jobs], sorted(path.name for path in results.iterdir()) if results.exists() else []


def assert_problem(answer, status, told):
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    problem = answer.json()
    assert problem.keys() == {"type", "title", "status", "detail", "instance", "errors"}
    assert problem["status"] == status
    assert told in problem["detail"], problem["detail"]
