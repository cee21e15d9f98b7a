"""The public functions of the kernels document every parameter, what they return and what they raise."""

import ast
import doctest
import inspect
import textwrap

import pytest
from numpydoc.validate import validate

import rattle_kernels

# No docstring, no summary; parameters missing, unknown, out of order, without a type or a description; returns missing.
ERRORS = {"GL08", "SS01", "PR01", "PR02", "PR03", "PR04", "PR07", "RT01", "YD01"}
# Enumerations and tuples describe their fields in prose.
FUNCTIONS = sorted(name for name in rattle_kernels.__all__ if inspect.isfunction(getattr(rattle_kernels, name)))


def exceptions_of(function):
    """Names that a function raises itself, and OutsideDomain where it checks an oscillator."""
    nodes = list(ast.walk(ast.parse(textwrap.dedent(inspect.getsource(function)))))
    raised = [node.exc for node in nodes if isinstance(node, ast.Raise) and node.exc is not None]
    names = {(exc.func if isinstance(exc, ast.Call) else exc).id for exc in raised}
    called = {node.func.id for node in nodes if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}
    checks = {"check_domain", "check_oscillator", "check_impacting", "check_invertible", "check_release", "check_quiet"}
    return names | ({"OutsideDomain"} if called & checks else set())


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_public_function_is_documented_completely(name):
    found = validate(f"rattle_kernels.{name}")["errors"]
    assert [error for error in found if error[0] in ERRORS] == []


@pytest.mark.parametrize("name", FUNCTIONS)
def test_what_a_public_function_raises_is_documented(name):
    function = getattr(rattle_kernels, name)
    _, _, section = (inspect.getdoc(function) or "").partition("Raises\n------\n")
    assert {raised for raised in exceptions_of(function) if raised not in section} == set()


@pytest.mark.parametrize("name", [name for name in rattle_kernels.__all__ if callable(getattr(rattle_kernels, name))])
def test_examples_of_public_names_run(name):
    whole = vars(rattle_kernels)
    for example in doctest.DocTestFinder(recurse=False).find(getattr(rattle_kernels, name), name, globs=dict(whole)):
        assert doctest.DocTestRunner().run(example).failed == 0


def test_the_check_finds_what_is_missing():
    assert len(FUNCTIONS) > 40
    assert exceptions_of(rattle_kernels.previous_impacts) == {"OutsideDomain"}
    assert exceptions_of(rattle_kernels.next_impacts) == {"OutsideDomain", "ValueError"}
