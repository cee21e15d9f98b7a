"""The published API is the one that is served."""

from pathlib import Path

import yaml
from service.models.oscillator import ImpactingOscillator, PiecewiseLinearOscillator

from rattle_kernels import Oscillator
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


def test_the_requests_oscillators_have_the_fields_and_defaults_of_the_kernels():
    common = {"damping", "eccentricity", "half_backlash"}
    assert set(ImpactingOscillator.model_fields) == common | {"model"}
    others = {"model", "permanent_contact", "allow_no_quiet_solution"}
    assert set(PiecewiseLinearOscillator.model_fields) - others == common | {"stiffness"}
    assert common | {"stiffness", "permanent_after"} == set(Oscillator._fields)
    assert ImpactingOscillator().to_oscillator() == Oscillator()
    stiff = PiecewiseLinearOscillator(model="piecewise_linear", stiffness=100.0)
    assert stiff.to_oscillator() == Oscillator(stiffness=100.0)
