"""The OpenAPI document: FastAPI's own, with problem documents, keys, and the errors that any request may meet."""

from typing import Any

from fastapi import FastAPI

from service.middleware.authentication import OPEN_PATHS, required_scope
from service.models.models import EventView, Problem

_ANYWHERE = {
    401: "no key, or none of this service's",
    403: "the key does not allow it",
    421: "without keys, the Host header has to name this machine",
    503: "the database, the store or the cluster does not answer",
}
_WITH_BODY = {
    400: "malformed JSON",
    413: "body too large",
    422: "what is wrong with the request, field by field",
}
_READING = ("get", "head")


def describe(app: FastAPI) -> dict[str, Any]:
    """OpenAPI document of the application."""
    if app.openapi_schema is not None:
        return app.openapi_schema
    schema = FastAPI.openapi(app)
    schemas = schema["components"]["schemas"]
    for model in (Problem, EventView):
        described = model.model_json_schema(ref_template="#/components/schemas/{model}", mode="serialization")
        schemas |= described.pop("$defs", {}) | {model.__name__: described}
    for unused in ("HTTPValidationError", "ValidationError"):
        schemas.pop(unused, None)
    schema["components"]["securitySchemes"] = {
        "key": {
            "type": "http",
            "scheme": "bearer",
            "description": "Not needed where a service listens on loopback only",
        }
    }
    for path, operations in schema["paths"].items():
        for method, operation in operations.items():
            for response in operation["responses"].values():
                _as_problem(response)
            _add_problems(operation, {} if method in _READING else _WITH_BODY)
            if path not in OPEN_PATHS:
                _add_problems(operation, _ANYWHERE)
                operation["security"] = [{"key": [str(required_scope(method.upper()))]}, {}]
    return schema


def _add_problems(operation: dict[str, Any], problems: dict[int, str]) -> None:
    for status, detail in problems.items():
        operation["responses"].setdefault(str(status), _problem(detail))


def _problem(detail: str) -> dict[str, Any]:
    content = {"application/problem+json": {"schema": {"$ref": "#/components/schemas/Problem"}}}
    return {"description": detail, "content": content}


def _as_problem(response: dict[str, Any]) -> None:
    """Replace FastAPI's own 422 body by the problem document that this service answers with."""
    content = response.get("content", {}).get("application/json", {})
    if content.get("schema", {}).get("$ref", "").endswith("/HTTPValidationError"):
        response |= _problem("what is wrong with the request, field by field")
