"""Prints the API's OpenAPI document as YAML: ``python -m service.openapi > docs/openapi.yaml``."""

import sys
from typing import Any

import yaml

from service.app import create_app
from service.models import Problem
from service.settings import Settings


def document() -> dict[str, Any]:
    """OpenAPI document of the application, with the schema that all problem documents have."""
    schema: dict[str, Any] = create_app(Settings.model_construct()).openapi()
    problem = Problem.model_json_schema(ref_template="#/components/schemas/{model}")
    schemas = schema["components"]["schemas"]
    schemas |= problem.pop("$defs") | {"Problem": problem}
    for unused in ("HTTPValidationError", "ValidationError"):
        schemas.pop(unused, None)
    for path in schema["paths"].values():
        for operation in path.values():
            for response in operation["responses"].values():
                _as_problem(response)
    return schema


def _as_problem(response: dict[str, Any]) -> None:
    """FastAPI declares its own body for 422; ours is a problem document like all others."""
    content = response.get("content", {}).get("application/json", {})
    if content.get("schema", {}).get("$ref", "").endswith("/HTTPValidationError"):
        response["description"] = "what is wrong with the request, field by field"
        response["content"] = {"application/problem+json": {"schema": {"$ref": "#/components/schemas/Problem"}}}


def as_yaml() -> str:
    """Document as it is committed."""
    return yaml.safe_dump(document(), sort_keys=False, allow_unicode=True, width=120)


if __name__ == "__main__":
    sys.stdout.write(as_yaml())
