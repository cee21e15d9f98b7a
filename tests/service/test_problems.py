"""Every error that a client can see has the documented status and kind, and says what its exception says."""

import asyncio

import httpx2 as httpx
import pytest
from fastapi import FastAPI

from rattle_kernels import OutsideDomain
from service import errors as service_errors
from service import problems
from service.records.engine import DatabaseError, DatabaseGone
from service.settings import Settings
from worker import errors as worker_errors

DOCUMENTED = {
    OutsideDomain("damping", 0.0, "positivity", 0.0, "damping must be positive"): (422, "outside-domain"),
    worker_errors.SweptOutsideDomain(
        OutsideDomain("damping", 0.0, "positivity", 0.0, "told"), ("vary", 0, "values", 2), "value 2"
    ): (422, "outside-domain"),
    worker_errors.InvalidJob("no such field", ("grid",)): (422, "invalid-request"),
    worker_errors.InvalidFields([(("grid",), "is wrong")]): (422, "invalid-request"),
    service_errors.LimitExceeded("too large"): (422, "limit-exceeded"),
    worker_errors.NotFound("no saddle"): (422, "nothing-found"),
    service_errors.TooMuch("too many", 7): (429, "too-much"),
    service_errors.JobNotFound("there is no job"): (404, "not-found"),
    service_errors.NotReady("no result yet"): (404, "not-ready"),
    service_errors.WrongKind("is of kind basin"): (409, "wrong-kind"),
    worker_errors.StoreConflict("another store"): (409, "store-conflict"),
    service_errors.Unstoppable("has not stopped"): (409, "still-stopping"),
    service_errors.NotYours("another's"): (403, "not-yours"),
    worker_errors.StoreFailed("cannot be read"): (503, "store-failed"),
    worker_errors.DamagedMetadata("basin.zarr", "solution"): (503, "store-failed"),
    worker_errors.OtherArrays("basin.zarr", "solution"): (503, "store-failed"),
    worker_errors.DamagedChunk("basin.zarr", "solution", "3/0"): (503, "store-failed"),
    worker_errors.ClusterFailed("no scheduler"): (503, "cluster-failed"),
    worker_errors.TileFailed("tile 3"): (500, "tile-failed"),
    worker_errors.UnlikeWorkers("another processor"): (503, "unlike-workers"),
    worker_errors.JobCancelled("stopped"): (409, "cancelled"),
    DatabaseError("lost"): (503, "database-failed"),
    DatabaseGone("the file was removed"): (503, "database-failed"),
    ZeroDivisionError("a secret"): (500, "internal"),
}


@pytest.fixture
def app(tmp_path):
    app = FastAPI()
    app.state.settings = Settings(data=tmp_path)
    problems.install_error_handlers(app)

    @app.get("/{number}")
    def fail(number: int):
        raise list(DOCUMENTED)[number]

    return app


def answer_of(app, path):
    async def ask():
        transport = httpx.ASGITransport(app=app, raise_app_exceptions=False)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            return await client.get(path)

    return asyncio.run(ask())


@pytest.mark.parametrize("error", DOCUMENTED, ids=lambda error: type(error).__name__)
def test_an_error_is_answered_as_documented(app, error):
    status, kind = DOCUMENTED[error]
    answer = answer_of(app, f"/{list(DOCUMENTED).index(error)}")
    told = answer.json()
    assert (answer.status_code, told["status"], told["type"]) == (status, status, f"/problems/{kind}")
    assert answer.headers["content-type"] == "application/problem+json"
    assert told["instance"] == f"/{list(DOCUMENTED).index(error)}" and told["detail"]
    assert answer.headers.get("retry-after") == ("7" if status == 429 else None)
    if kind == "internal":
        assert "secret" not in answer.text
    if not isinstance(error, DatabaseError):
        assert problems.kind_of(error) == kind
    if place := getattr(error, "place", ()):
        assert told["errors"][0]["location"] == ["body", *place]


def test_no_error_is_forgotten():
    """Every row of the table is tried, and every error of the service and of the worker that a request can meet."""
    assert set(problems._TABLE) <= {type(error) for error in DOCUMENTED}
    raised = {
        each for module in (service_errors, worker_errors) for each in vars(module).values()
        if isinstance(each, type) and issubclass(each, Exception) and each.__module__ == module.__name__
    }  # fmt: skip
    # These end before a request: the base, a wrong setting, and a driver's own.
    inner = {"WorkerError", "InvalidSettings", "LeaseLost"}
    unknown = {each.__name__ for each in raised if problems.kind_of(each.__new__(each)) == "internal"}
    assert unknown == inner


def test_what_lies_where_is_the_services_own_affair(app):
    app.state.settings = Settings(store="/srv/results")
    error = worker_errors.StoreFailed("the store /srv/results/0af.zarr cannot be read")
    assert problems.without_paths(str(error), "/srv/results/") == "the store 0af.zarr cannot be read"
