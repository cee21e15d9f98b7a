"""Every public name has an example in its documentation, and the examples run."""

import doctest
import inspect
import sys

import pytest

import rattle
import rattle_proof
from rattle import pictures
from rattle.results.accessor import Result
from rattle_proof.results import certificate

ADDRESS = "http://127.0.0.1:8000"
NAMES = {f"rattle.{name}": getattr(rattle, name) for name in rattle.__all__}
MEMBERS = {name: inspect.getattr_static(Result, name) for name in dir(Result) if not name.startswith("_")}
PARTS = {name: getattr(pictures, name) for name in pictures.__all__ if callable(getattr(pictures, name))}
DOCUMENTED = (
    NAMES
    | {"rattle": rattle, "rattle.pictures": pictures, ".rattle": Result}
    | {f".rattle.{name}": member for name, member in MEMBERS.items()}
    | {f"rattle.pictures.{name}": part for name, part in PARTS.items()}
    | {f"rattle_proof.{name}": getattr(rattle_proof, name) for name in rattle_proof.__all__}
    | {"rattle_proof.results.certificate": certificate}
    | {"rattle.pulses": rattle.pulses, "rattle.threshold": rattle.threshold}
    | {"rattle.tolerances": rattle.tolerances, "rattle.report": rattle.report}
    | {"rattle.explore": rattle.explore}
)


def module_of(documented):
    """Module whose names an example may use as they are."""
    documented = getattr(documented, "fget", None) or getattr(documented, "func", None) or documented
    return vars(sys.modules[getattr(documented, "__module__", "rattle")])


# Each of these computes for a second or more.
LONG = {"rattle.NotFound", "rattle.report", "rattle.sweep", "rattle.tolerances", ".rattle.measures"}


def marked(name):
    if name.startswith("rattle_proof."):
        return pytest.param(name, marks=pytest.mark.proof)
    return pytest.param(name, marks=pytest.mark.slow) if name in LONG else name


@pytest.mark.parametrize("name", [marked(name) for name in DOCUMENTED])
def test_a_public_name_has_an_example_that_runs(name, tmp_path, monkeypatch, request, capsys):
    """Where an example asks a service, one of the tests answers."""
    monkeypatch.chdir(tmp_path)
    text = inspect.getdoc(DOCUMENTED[name]) or ""
    if ADDRESS in text:
        text = text.replace(ADDRESS, request.getfixturevalue("service").url)
    example = doctest.DocTestParser().get_doctest(text, module_of(DOCUMENTED[name]) | {"rattle": rattle}, name, None, 0)
    assert example.examples, f"the documentation of {name} has no example"
    failed, _ = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(example)
    assert failed == 0, capsys.readouterr().out


def test_what_is_looked_at_is_all_there_is():
    assert len(NAMES) > 25 and len(MEMBERS) > 15 and len(PARTS) > 10
    assert {".rattle.plot", ".rattle.basins", ".rattle.to_csv", "rattle.compute", "rattle.pictures.frame"} <= set(
        DOCUMENTED
    )
