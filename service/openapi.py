"""Prints the API's OpenAPI document as YAML: ``python -m service.openapi > docs/openapi.yaml``."""

import sys
from typing import Any

import yaml

from service.app import create_app
from service.settings import Settings


def document() -> dict[str, Any]:
    """OpenAPI document, as the service itself answers it at ``/openapi.json``."""
    return create_app(Settings.model_construct()).openapi()


def as_yaml() -> str:
    """Document as it is committed."""
    return yaml.safe_dump(document(), sort_keys=False, allow_unicode=True, width=120)


if __name__ == "__main__":
    sys.stdout.write(as_yaml())
