"""The OpenAPI document: FastAPI's own, with problem documents, keys, and the errors that any request may get."""

import re
from collections import Counter
from typing import Any

from fastapi import FastAPI

from service.middleware.authentication import OPEN_PATHS, required_scope
from service.models.jobs import EventView
from service.models.problems import Problem

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
_COMPONENTS = "#/components/schemas/"
# Sections of a docstring, such as Raises and Examples, are for Python.
_SECTION = re.compile(r"\n\n\w+\n-{3,}\n")


def describe(app: FastAPI) -> dict[str, Any]:
    """OpenAPI document of the application."""
    if app.openapi_schema is not None:
        return app.openapi_schema
    schema = app.openapi_schema = _named_by_title(FastAPI.openapi(app))
    schemas = schema["components"]["schemas"]
    for model in (Problem, EventView):
        described = model.model_json_schema(ref_template=_COMPONENTS + "{model}", mode="serialization")
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
    for each in schemas.values():
        if "description" in each:
            each["description"] = _SECTION.split(each["description"], maxsplit=1)[0]
    for path, operations in schema["paths"].items():
        for method, operation in operations.items():
            for response in operation["responses"].values():
                _as_problem(response)
            _add_problems(operation, {} if method in _READING else _WITH_BODY)
            if path not in OPEN_PATHS:
                _add_problems(operation, _ANYWHERE)
                operation["security"] = [{"key": [str(required_scope(method.upper()))]}, {}]
    return schema


def _named_by_title(schema: dict[str, Any]) -> dict[str, Any]:
    """The document with each component named by its title, if that is unique: a `BasinJob` is a BasinRequest."""
    components = schema["components"]["schemas"]
    known = Counter(each.get("title") for each in components.values())
    titles = {name: each["title"] if known[each.get("title")] == 1 else name for name, each in components.items()}
    schema["components"]["schemas"] = {
        titles[name]: components[name] for name in sorted(components, key=titles.__getitem__)
    }
    return _with_references(schema, {f"{_COMPONENTS}{name}": f"{_COMPONENTS}{title}" for name, title in titles.items()})


def _with_references(part: Any, renamed: dict[str, str]) -> Any:
    if isinstance(part, dict):
        return {name: _with_references(value, renamed) for name, value in part.items()}
    if isinstance(part, list):
        return [_with_references(value, renamed) for value in part]
    return renamed.get(part, part) if isinstance(part, str) else part


def _add_problems(operation: dict[str, Any], problems: dict[int, str]) -> None:
    for status, detail in problems.items():
        operation["responses"].setdefault(str(status), _problem(detail))


def _problem(detail: str) -> dict[str, Any]:
    content = {"application/problem+json": {"schema": {"$ref": f"{_COMPONENTS}Problem"}}}
    return {"description": detail, "content": content}


def _as_problem(response: dict[str, Any]) -> None:
    """Replace FastAPI's own 422 body by the problem document that this service sends."""
    content = response.get("content", {}).get("application/json", {})
    if content.get("schema", {}).get("$ref", "").endswith("/HTTPValidationError"):
        response |= _problem("what is wrong with the request, field by field")
