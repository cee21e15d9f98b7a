"""Print the OpenAPI document of the API as YAML: ``python -m service.openapi > docs/openapi.yaml``."""

import sys
from typing import Any

import yaml

from service.app import create_app
from service.settings import Settings


def document() -> dict[str, Any]:
    """OpenAPI document, as at ``/openapi.json``."""
    return create_app(Settings.model_construct()).openapi()


def as_yaml() -> str:
    """Document as committed in ``docs/openapi.yaml``."""
    return yaml.safe_dump(document(), sort_keys=False, allow_unicode=True, width=120)


if __name__ == "__main__":
    sys.stdout.write(as_yaml())
