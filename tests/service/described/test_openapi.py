"""The published API is the one that is served."""

from pathlib import Path

import yaml

from service.openapi import as_yaml, document


def test_the_committed_document_is_the_codes():
    committed = (Path(__file__).parents[3] / "docs" / "openapi.yaml").read_text()
    assert committed == as_yaml(), "run `make openapi`"


def test_every_reference_resolves_and_every_operation_is_described():
    schema = document()
    text = yaml.safe_dump(schema)
    for name in {line.split("/")[-1].strip("'\"") for line in text.splitlines() if "$ref:" in line}:
        assert name in schema["components"]["schemas"]
    for path in schema["paths"].values():
        for operation in path.values():
            assert operation["summary"] and operation["description"]


def test_no_two_models_share_a_name():
    """FastAPI puts the module before such a name, with two underscores."""
    assert [name for name in document()["components"]["schemas"] if "__" in name] == []
