"""Every error that a client can see: one table of exception, status and kind, sent as problem+json (RFC 9457)."""

import logging
import uuid
from collections.abc import Sequence
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from fastapi.routing import iter_route_contexts
from starlette.exceptions import HTTPException

from rattle_kernels import OutsideDomain
from service.errors import JobNotFound, LimitExceeded, NotReady, NotYours, TooMuch, Unstoppable, WrongKind
from service.records.engine import DatabaseError, DatabaseGone
from worker.errors import (
    ClusterFailed,
    FieldPath,
    InvalidFields,
    InvalidJob,
    JobCancelled,
    NotFound,
    StoreConflict,
    StoreFailed,
    SweptOutsideDomain,
    TileFailed,
    UnlikeWorkers,
)
from worker.jobs.request import fault_of

_log = logging.getLogger("rattle.service")

_TABLE: dict[type[Exception], tuple[int, str]] = {
    OutsideDomain: (422, "outside-domain"),
    InvalidJob: (422, "invalid-request"),
    LimitExceeded: (422, "limit-exceeded"),
    NotFound: (422, "nothing-found"),
    TooMuch: (429, "too-much"),
    JobNotFound: (404, "not-found"),
    NotReady: (404, "not-ready"),
    WrongKind: (409, "wrong-kind"),
    StoreConflict: (409, "store-conflict"),
    Unstoppable: (409, "still-stopping"),
    NotYours: (403, "not-yours"),
    StoreFailed: (503, "store-failed"),
    ClusterFailed: (503, "cluster-failed"),
    TileFailed: (500, "tile-failed"),
    UnlikeWorkers: (503, "unlike-workers"),
    JobCancelled: (409, "cancelled"),
}

_KIND_OF_STATUS = {
    400: "malformed-request", 404: "not-found", 405: "method-not-allowed", 413: "body-too-large", 415:
    "unsupported-media-type", 416: "range-not-satisfiable", 422: "invalid-request",
    503: "overloaded",
}  # fmt: skip


class MalformedBody(HTTPException):
    """A request body that no route accepts.

    Parameters
    ----------
    status_code : int
    message : str
        What is wrong with it.
    place : tuple of str and int
        Where; by default the body as a whole.
    """

    def __init__(self, status_code: int, message: str, place: FieldPath = ()) -> None:
        self.errors = [_fault(place, message)]
        super().__init__(status_code, _in_words(self.errors))


def without_paths(message: str, results: str) -> str:
    """A message for clients, in which a store has only its name: where this service keeps its files is its own affair.

    Parameters
    ----------
    message : str
    results : str
        Folder of all results.

    Returns
    -------
    str
    """
    return message.replace(f"{results.rstrip('/')}/", "")


def kind_of(error: Exception) -> str:
    """Stable kind of an error, as in ``type`` of a problem and in a failed job's record."""
    return next((kind for known, (_, kind) in _TABLE.items() if isinstance(error, known)), "internal")


def problem(
    status: int, kind: str, detail: str, instance: str, errors: Sequence[dict[str, Any]] = (), headers: Any = None
) -> JSONResponse:
    """Problem document."""
    body = {
        "type": f"/problems/{kind}",
        "title": HTTPStatus(status).phrase,
        "status": status,
        "detail": detail,
        "instance": instance,
        "errors": list(errors),
    }
    return JSONResponse(body, status, headers=headers, media_type="application/problem+json")


def database_problem(error: Exception, instance: str) -> JSONResponse:
    """Problem document for an error of the database."""
    detail = str(error) if isinstance(error, DatabaseGone) else "the database does not answer; try again later"
    return problem(503, "database-failed", detail, instance)


def faults_of(error: Exception) -> list[dict[str, Any]]:
    """What is wrong with a request, field by field.

    Parameters
    ----------
    error : Exception
        The error that refused the submission.

    Returns
    -------
    list of dict
        Locations and messages.
    """
    if isinstance(error, InvalidFields):
        return [_fault(path, message) for path, message in error.faults]
    if isinstance(error, InvalidJob | SweptOutsideDomain):
        return [_fault(error.place, str(error))]
    return [_fault(("oscillator", error.parameter) if isinstance(error, OutsideDomain) else (), str(error))]


def _fault(path: tuple[str | int, ...], message: str) -> dict[str, Any]:
    return {"location": ["body", *path], "message": message}


def _in_words(faults: list[dict[str, Any]]) -> str:
    return "; ".join(f"{'.'.join(str(part) for part in each['location'])}: {each['message']}" for each in faults)


async def _known(request: Request, error: Exception) -> JSONResponse:
    status, kind = next(entry for known, entry in _TABLE.items() if isinstance(error, known))
    faults = faults_of(error)
    detail = _in_words(faults) if isinstance(error, InvalidFields) else str(error)
    detail = without_paths(detail, request.app.state.settings.results)
    errors = [each for each in faults if each["location"] != ["body"]]
    headers = {"Retry-After": str(error.seconds)} if isinstance(error, TooMuch) else None
    return problem(status, kind, detail, request.url.path, errors, headers)


def _field_error(item: dict[str, Any]) -> dict[str, Any]:
    path, message = fault_of(item)
    if item["type"] == "json_invalid":
        return {"location": ["body"], "message": f"not valid JSON at character {path[-1]}"}
    if path == ("body",):
        message = "send a JSON object, with the header content-type: application/json"
    return {"location": list(path), "message": message}


async def _invalid(request: Request, error: Exception) -> JSONResponse:
    """Respond to a validation error. The input is not echoed: it may contain NaN, which JSON cannot represent."""
    assert isinstance(error, RequestValidationError)
    errors = [_field_error(item) for item in error.errors()]
    malformed = any(item["type"] == "json_invalid" for item in error.errors())
    status, kind = (400, "malformed-request") if malformed else (422, "invalid-request")
    return problem(status, kind, _in_words(errors), request.url.path, errors)


async def _http(request: Request, error: Exception) -> JSONResponse:
    assert isinstance(error, HTTPException)
    detail = str(error.detail)
    if error.status_code == 404 and detail == "Not Found":
        detail = f"there is nothing at {request.url.path}; see /docs for what is there"
    kind = _KIND_OF_STATUS.get(error.status_code, "error")
    errors = error.errors if isinstance(error, MalformedBody) else ()
    headers = dict(error.headers or {})
    if error.status_code == 405 and (allowed := _methods_at(request)):
        headers["allow"] = ", ".join(sorted(allowed))
    return problem(error.status_code, kind, detail, request.url.path, errors, headers)


def _methods_at(request: Request) -> set[str]:
    """Methods of all routes at an address. Starlette tells those of the first one alone."""
    methods: set[str] = set()
    for route in iter_route_contexts(request.app.routes):
        pattern = getattr(route, "path_regex", None)
        if pattern is not None and pattern.match(request.url.path):
            methods |= route.methods or set()
    return methods | {"HEAD"} if "GET" in methods else methods


async def _database(request: Request, error: Exception) -> JSONResponse:
    _log.error("the database does not answer at %s", request.url.path, exc_info=error)
    return database_problem(error, request.url.path)


async def _unexpected(request: Request, error: Exception) -> JSONResponse:
    identifier = uuid.uuid4().hex
    _log.error("unexpected error %s at %s", identifier, request.url.path, exc_info=error)
    return problem(500, "internal", f"unexpected error; its identifier in the log is {identifier}", request.url.path)


def install_error_handlers(app: FastAPI) -> None:
    """Respond to every error of `app` with a problem document."""
    for known in _TABLE:
        app.add_exception_handler(known, _known)
    app.add_exception_handler(RequestValidationError, _invalid)
    app.add_exception_handler(HTTPException, _http)
    app.add_exception_handler(DatabaseError, _database)
    app.add_exception_handler(Exception, _unexpected)
