"""The published API is the one that is served."""

from pathlib import Path

import yaml

from rattle_kernels import Oscillator
from service.models import OscillatorRequest
from service.openapi import as_yaml, document


def test_the_committed_document_is_the_codes():
    committed = (Path(__file__).parents[2] / "docs" / "openapi.yaml").read_text()
    assert committed == as_yaml(), "run `make openapi`"


def test_every_reference_resolves_and_every_operation_is_described():
    schema = document()
    text = yaml.safe_dump(schema)
    for name in {line.split("/")[-1].strip("'\"") for line in text.splitlines() if "$ref:" in line}:
        assert name in schema["components"]["schemas"]
    for path in schema["paths"].values():
        for operation in path.values():
            assert operation["summary"] and operation["description"]


def test_the_requests_oscillator_has_the_fields_of_the_kernels():
    assert set(OscillatorRequest.model_fields) - {"model"} == set(Oscillator._fields) - {"stiffness"}
    request = OscillatorRequest()
    assert all(getattr(request, name) == value for name, value in Oscillator()._asdict().items() if name != "stiffness")
