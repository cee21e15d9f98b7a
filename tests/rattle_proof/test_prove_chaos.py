"""`rattle.prove_chaos` and its command: what they say, and what they refuse."""

import json
import math

import pytest
from typer.testing import CliRunner

import rattle
from rattle.cli import app
from rattle_kernels import Oscillator, OutsideDomain
from worker.errors import InvalidJob

FIG_7 = Oscillator(damping=0.6, eccentricity=0.1, half_backlash=0.6)
QUICK = {"columns": 1024, "leaves": 40, "cycles": 1}


@pytest.fixture(scope="module")
def found():
    return rattle.prove_chaos(FIG_7, **QUICK)


def test_it_says_what_is_proven_and_rounds_down(found):
    numerator, denominator = found.growth
    assert 0.0 < found.entropy < math.log(numerator / denominator)
    assert found.repelling == 1 and found.leaves >= 5 and found.columns == 1024 and found.boxes > 1000
    text = str(found)
    told = float(text.split("at least ")[1].split()[0])
    assert found.entropy - 1e-4 < told <= found.entropy
    assert "no cycle of up to 1 impacts attracts" in text and "not decided" not in text


def test_the_same_again_is_the_same(found):
    assert rattle.prove_chaos(FIG_7, **QUICK) == found


def test_the_command_says_the_same(found):
    ran = CliRunner().invoke(app, ["prove-chaos", "--columns", "1024", "--leaves", "40", "--cycles", "1", "--json"])
    assert ran.exit_code == 0, ran.output
    told = json.loads(ran.stdout)
    assert told == json.loads(json.dumps(found.to_dict()))


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ({"columns": 1000}, "power of two"),
        ({"columns": 128}, "from 256 to 8192"),
        ({"leaves": 2.5}, "whole number"),
        ({"cycles": 9}, "from 0 to 8"),
        ({"tolerances": {"stiffness": (1.0, 2.0)}}, "stiffness has no tolerance"),
        ({"tolerances": {"damping": (0.61, 0.7)}}, "does not lie between"),
    ],
)
def test_a_wrong_argument_is_named(arguments, why):
    with pytest.raises(InvalidJob, match=why):
        rattle.prove_chaos(FIG_7, **arguments)


def test_a_machine_without_chaos_or_of_finite_stiffness_or_beyond_eq_8_is_refused():
    with pytest.raises(InvalidJob, match="no chaotic motion is found: those found are permanent contact"):
        rattle.prove_chaos(Oscillator(1.5, 0.1, 0.6))
    with pytest.raises(InvalidJob, match="impacting model"):
        rattle.prove_chaos(Oscillator(0.6, 0.1, 0.6, stiffness=1e4))
    with pytest.raises(OutsideDomain):
        rattle.prove_chaos(Oscillator(0.6, 0.25, 0.6))


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (["--tolerance", "damping"], "damping=0.59999:0.60001"),
        (["--tolerance", "damping=0.5:x"], "damping=0.59999:0.60001"),
        (["--damping", "1.5"], "no chaotic motion"),
        (["--cycles", "9"], "from 0 to 8"),
        (["absent.toml"], "absent.toml"),
    ],
)
def test_the_command_refuses_with_a_reason(options, why):
    ran = CliRunner().invoke(app, ["prove-chaos", *options])
    assert ran.exit_code == 2 and why in ran.output.replace("\n", ""), ran.output
