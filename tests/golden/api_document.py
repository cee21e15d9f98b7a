"""The OpenAPI document without its words."""

from pathlib import Path

import yaml

DOCUMENT = Path(__file__).parents[2] / "docs" / "openapi.yaml"
WORDS = {"description", "summary", "title", "example", "examples"}
NAMES = {"properties", "schemas", "paths", "parameters"}
"""What holds names of our own, which may be one of the words."""


def structure():
    """The committed document without its words, and without what it says of the whole."""
    document = yaml.safe_load(DOCUMENT.read_text())
    return {name: _without_words(value, name in NAMES) for name, value in document.items() if name != "info"}


def _without_words(value, names=False):
    if isinstance(value, list):
        return [_without_words(each) for each in value]
    if isinstance(value, dict):
        return {name: _without_words(each, name in NAMES) for name, each in value.items() if names or name not in WORDS}
    return value
