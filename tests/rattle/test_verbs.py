"""The verbs are written out, and agree with the jobs that they describe; type checkers see through them."""

import inspect
import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from numpydoc.validate import validate

import rattle
from rattle.arguments import job_of
from rattle.cli.options import LEAST, options_of, texts_of
from rattle.verbs import VERBS
from rattle_proof.request import ProofRequest
from worker.jobs.oscillator_request import ImpactingOscillator, PiecewiseLinearOscillator
from worker.jobs.region import ResolutionRequest
from worker.jobs.sample import Sample
from worker.jobs.trajectory_request import StartRequest, TrajectoryRequest
from worker.kinds import KINDS
from worker.machine_series import MACHINES, UNITS

ROOT = Path(__file__).parents[2]
ALL = {**VERBS, "trajectory": rattle.trajectory}
WHERE = {"store", "workers", "scheduler", "progress"}
MACHINE = {"machine"}
"""In place of the oscillator's numbers."""
OSCILLATOR = ImpactingOscillator.model_fields | PiecewiseLinearOscillator.model_fields
PARTS = {
    "grid": {"cells", "time", "velocity"},
    "sample": {"sample", "seed", "scramblings"},
    "prove": {"prove", "levels", "tolerances"},
    "vary": {"of_harmonics"},
    "design": {MACHINES, *UNITS},
    "region": {"time", "velocity"},
    "resolution": {"chord", "angle"},
}
"""Arguments that make a field of a request; of the others the field has the name."""
ONLY_IN_JSON = {
    "manifold": {"kind", "most_points", "region", "cells"},
    "grazing_curve": {"kind", "most_points"},
    "sweep": {"kind", "prove"},
}
NEEDED = {"sweep": {"damping": [0.6]}, "bifurcation": {"damping": [0.6]}, "manifold": {"saddles": ["P(1,1,0)"]}}
# Of no use alone: what they belong to is asked for by another argument.
BESIDE = {"seed": Sample(1).seed, "scramblings": Sample(1).scramblings, "levels": ProofRequest().levels}
DOCSTRINGS = {"GL08", "SS01", "PR01", "PR02", "PR03", "PR04", "PR07", "RT01", "YD01"}


def parameters_of(kind):
    return dict(inspect.signature(ALL[kind]).parameters)


@pytest.mark.parametrize("kind", VERBS)
def test_a_verb_has_the_arguments_that_its_job_has_fields(kind):
    fields = {field.alias for field in KINDS[kind].job_class.model_fields.values()}
    fields -= ONLY_IN_JSON.get(kind, {"kind"})
    of_models = [ImpactingOscillator] + [PiecewiseLinearOscillator] * (not KINDS[kind].job_class.impacting_only)
    names = {name for model in of_models for name in model.model_fields} - {"model"}
    for field in fields - {"oscillator"}:
        names |= PARTS.get(field, {field})
    assert parameters_of(kind).keys() == names | WHERE | MACHINE


@pytest.mark.parametrize("kind", VERBS)
def test_defaults_of_a_verb_are_those_of_its_job(kind):
    given = {name: each.default for name, each in parameters_of(kind).items() if each.default is not each.empty}
    beside = {name: value for name, value in given.items() if name in BESIDE}
    assert beside == {name: BESIDE[name] for name in beside}
    of_contacts = PiecewiseLinearOscillator.model_fields.keys() - ImpactingOscillator.model_fields.keys()
    asked = {name: value for name, value in given.items() if value is not None}
    asked = {name: value for name, value in asked.items() if name not in {*WHERE, *beside, *of_contacts}}
    assert job_of(kind, asked | NEEDED.get(kind, {})).digest == job_of(kind, NEEDED.get(kind, {})).digest
    for name in of_contacts & given.keys() - {"stiffness"}:
        assert given[name] == OSCILLATOR[name].default


def test_defaults_of_a_trajectory_are_those_of_its_request():
    fields = OSCILLATOR | StartRequest.model_fields | TrajectoryRequest.model_fields
    for name, each in parameters_of("trajectory").items():
        if each.default not in (None, each.empty):
            assert each.default == fields[name].default, name


@pytest.mark.parametrize("kind", ALL)
def test_help_is_what_the_fields_say_of_themselves(kind):
    own = {} if kind == "trajectory" else {f.alias: f for f in KINDS[kind].job_class.model_fields.values()}
    of_parts = OSCILLATOR | ResolutionRequest.model_fields
    if kind == "trajectory":
        of_parts |= StartRequest.model_fields | TrajectoryRequest.model_fields
    for name, text in texts_of(ALL[kind]).items():
        # What a machine, a measured curve or a list is written as, Python says in its own way.
        if name in {"machine", "harmonics", "transmission_error", "sample", "seeds", "continuation", "curves"}:
            continue
        field = own.get(name) or of_parts.get(name)
        if field is not None and field.description:
            assert text.startswith(field.description), name


@pytest.mark.parametrize("kind", VERBS)
def test_least_values_of_options_are_those_of_the_fields(kind):
    refused = {name: least - 1 for name, least in LEAST.items() if name in parameters_of(kind)}
    for name, value in refused.items():
        beside = {"prove": True} if name == "levels" else {}
        with pytest.raises(ValueError, match=f"{name}: Input should be greater than or equal to {value + 1}"):
            job_of(kind, {name: value} | beside | NEEDED.get(kind, {}))
    options = {each.name for each in options_of(VERBS[kind])}
    assert refused.keys() <= options


@pytest.mark.parametrize("name", [*(verb.__name__ for verb in ALL.values()), "compute"])
def test_a_verb_is_documented_completely(name):
    found = validate(f"rattle.{name}")["errors"]
    assert [error for error in found if error[0] in DOCSTRINGS] == []


SCRIPT = """
import rattle

reveal_type(rattle.basin(damping=0.5, cells=(20, 30), permanent_contact="envelope"))
reveal_type(rattle.sweep(damping=[0.5, 0.6], phase_2=(0, 1, 5)))
rattle.basin(dampign=0.5)
rattle.basin(damping="0.5")
rattle.basin(permanent_contact="never")
there = rattle.connect("http://127.0.0.1:8000")
reveal_type(there.basin(damping=0.5))
there.basin(dampign=0.5)
there.basin(damping="0.5")
there.manifolds()
rattle.Oscillator(damping="0.5")
rattle.basins()
"""
SEEN = [
    (4, 'Revealed type is "xarray.core.dataset.Dataset"'),
    (5, 'Revealed type is "xarray.core.dataset.Dataset"'),
    (6, 'Unexpected keyword argument "dampign" for "basin"'),
    (7, 'Argument "damping" to "basin" has incompatible type "str"'),
    (8, 'Argument "permanent_contact" to "basin" has incompatible type'),
    (10, 'Revealed type is "xarray.core.dataset.Dataset"'),
    (11, 'Unexpected keyword argument "dampign"'),
    (12, 'Argument "damping" has incompatible type "str"'),
    (13, 'Missing named argument "saddles"'),
    (14, 'Argument "damping" to "Oscillator" has incompatible type "str"'),
    (15, 'Module has no attribute "basins"'),
]
CONFIG = """
[mypy]
follow_imports = silent
ignore_missing_imports = True

[mypy-numba.*,llvmlite.*,distributed.*,dask.*,zarr.*,matplotlib.*,pandas.*,scipy.*]
follow_imports = skip
"""


@pytest.mark.timeout(600)
def test_a_type_checker_sees_datasets_and_misspelt_arguments(tmp_path):
    """As a user runs it on a script; what his script does not need is left out."""
    (tmp_path / "script.py").write_text(textwrap.dedent(SCRIPT))
    (tmp_path / "mypy.ini").write_text(CONFIG)
    told = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", "mypy.ini", "--no-error-summary", "script.py"],
        cwd=tmp_path, env=os.environ | {"MYPYPATH": str(ROOT)}, capture_output=True, text=True, timeout=590,
    )  # fmt: skip
    lines = [line for line in told.stdout.splitlines() if line.startswith("script.py:")]
    assert len([line for line in lines if ": note: " not in line or "Revealed" in line]) == len(SEEN), told.stdout
    for number, text in SEEN:
        assert any(line.startswith(f"script.py:{number}: ") and text in line for line in lines), (number, told.stdout)
