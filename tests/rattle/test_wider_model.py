"""The wider model at the front door: Python and the shell."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import rattle
from rattle.arguments import job_of
from rattle.cli import app
from rattle.cli.options import arguments_from, options_of
from worker.jobs.preview_request import PreviewRequest, preview_basin

# Two harmonics beside the first, as in the tests of the kernels, which are compiled for that number of them.
FORCING = [(2, 0.01, 0.0), (3, 0.0005, 0.3)]
QUICK = {"cells": 24, "iterations": 101, "progress": False}


@pytest.mark.slow
def test_the_phase_of_a_harmonic_is_swept_and_wraps():
    sweep = rattle.sweep(harmonics=FORCING, phase_2=(0, 1, 3), **QUICK)
    solution = sweep.solution.values
    np.testing.assert_array_equal(solution[0], solution[2])
    quiet = sweep.share.isel(attractor=0).values
    assert quiet[1] > quiet[0] + 0.1


def test_losses_make_a_machine_quieter_and_python_and_shell_ask_the_same(tmp_path):
    lossy = rattle.basin(restitution=0.9, **QUICK)
    assert float(lossy.share[0]) > float(rattle.basin(**QUICK).share[0]) + 0.05
    assert lossy.attrs["restitution"] == 0.9
    out = tmp_path / "basin.zarr"
    asked = ["basin", "--restitution", "0.9", "--cells", "24", "24", "--iterations", "101", "--out", str(out)]
    done = CliRunner().invoke(app, asked)
    assert done.exit_code == 0, done.output
    assert rattle.open(out).attrs["request_sha256"] == lossy.attrs["request_sha256"]


def test_the_shell_takes_harmonics():
    job = rattle.BasinJob(oscillator={"harmonics": [{"order": 2, "amplitude": 0.01, "phase": 0.25}]})
    for text in ("2:0.01:x", "2.5:0.01", "2", "2:0.01:0.25:0.5"):
        told = CliRunner().invoke(app, ["basin", "--harmonic", text, "--out", "never.zarr"])
        assert told.exit_code == 2 and f"--harmonic {text}: write order, amplitude and phase" in told.output
    values = {each.name: each.default for each in options_of(rattle.basin)}
    given = arguments_from(rattle.basin, values | {"harmonic": ["2:0.01:0.25", "3:0.01"]})
    assert given == {"harmonics": [(2, 0.01, 0.25), (3, 0.01, 0.0)]}
    assert job_of("basin", {"harmonics": given["harmonics"][:1]}).digest == job.digest


@pytest.mark.parametrize(
    ("given", "error", "told"),
    [
        ({"harmonics": [(2,)]}, ValueError, r"a harmonic is \(order, amplitude, phase\), not \(2,\)"),
        ({"harmonics": 0.01}, ValueError, "harmonics are a list of"),
        ({"harmonics": [(2.5, 0.01)]}, ValueError, "valid integer"),
        ({"phase_2": 0.3}, TypeError, "unexpected keyword argument 'phase_2'"),
        ({"phase_x": 0.3}, TypeError, "unexpected keyword argument 'phase_x'"),
        ({"restitution": 0.9, "stiffness": 100.0}, ValueError, "restitution belongs to the impacting model: leave out"),
        (
            {"contact_damping": 0.1},
            ValueError,
            "contact_damping belongs to the piecewise linear model: give a stiffness",
        ),
    ],
)
def test_what_cannot_be_asked_is_refused(given, error, told):
    with pytest.raises(error, match=told):
        rattle.basin(**given, progress=False)


@pytest.mark.slow
def test_a_motion_and_orbits_of_the_wider_model():
    motion = rattle.trajectory(velocity=3.0, periods=5.0, restitution=0.8, harmonics=FORCING)
    arrives, leaves = motion.velocity.values[np.flatnonzero(np.diff(motion.time.values) == 0.0)[0] + np.array([0, 1])]
    assert leaves == pytest.approx(-0.8 * arrives)
    found = rattle.orbits(longest=1, cells=8, restitution=0.9, harmonics=FORCING, progress=False)
    first = list(found.name.values).index("P(1,1,0)")
    assert float(found.orbit_velocity[first, 0]) == pytest.approx(4 * np.pi * 0.6 * 0.9 / 1.9, abs=1e-9)
    assert json.loads(found.attrs["harmonics"])[0] == {"order": 2, "amplitude": 0.01, "phase": 0.0}


@pytest.mark.slow
@pytest.mark.timeout(1200)  # kernels are compiled, also those of proofs
@pytest.mark.parametrize("number", [3, 32])
def test_every_verb_takes_as_many_harmonics_as_a_request_may_have(number):
    harmonics = [(n, 0.004 / (number * n), 0.37 * n % 1.0) for n in range(2, number + 2)]
    basin = rattle.basin(harmonics=harmonics, prove=True, **QUICK)
    assert len(json.loads(basin.attrs["harmonics"])) == number
    assert (basin.proven > 0).any()
    shown = preview_basin(
        PreviewRequest(
            oscillator={
                "harmonics": [dict(zip(("order", "amplitude", "phase"), each, strict=True)) for each in harmonics]
            }
        )
    )
    assert shown.solution.min() >= 0
    sweep = rattle.sweep(harmonics=harmonics, **{f"phase_{number + 1}": (0, 1, 2)}, **QUICK)
    np.testing.assert_array_equal(sweep.solution.values[0], sweep.solution.values[1])
    motion = rattle.trajectory(velocity=3.0, periods=5.0, harmonics=harmonics)
    assert np.isfinite(motion.velocity.values).all()
    found = rattle.orbits(longest=1, cells=8, harmonics=harmonics, progress=False)
    assert found.name.size
