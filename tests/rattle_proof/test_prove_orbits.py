"""`rattle.prove_orbits` and its command: what they say, and what they refuse."""

import json
import math

import pytest
from flint import ctx
from typer.testing import CliRunner

import rattle
from rattle.cli import app
from rattle_kernels import Oscillator, OutsideDomain
from worker.errors import InvalidJob

STIFF = Oscillator(0.6, 0.1, 0.6, stiffness=1e5)


@pytest.fixture(scope="module")
def found():
    return rattle.prove_orbits(STIFF)


def test_it_says_what_is_proven(found):
    assert found.contact.proven and 0.0 < found.contact.depth < 2.0 * math.pi * 0.6 / 1e5
    assert [(each.name, each.proven) for each in found.orbits] == [
        ("P(1,1,0)", True),
        ("P(1,2,0)", True),
        ("P(2,2,1)", True),
    ]
    for each in found.orbits:
        assert 0.0 <= each.error < 1e-9 < each.radius and 0.0 < each.contraction < 1.0 < each.slowest
    text = str(found)
    assert text.count("attracts") == 4 and "not proven" not in text
    told = [float(line.split("radius ")[1].split()[0]) for line in text.splitlines()[1:]]
    assert all(shown <= each.radius for shown, each in zip(told, found.orbits, strict=True))


def test_the_digits_of_others_stay_as_they_were(found):
    before = ctx.prec
    rattle.prove_orbits(STIFF, departures=1)
    assert ctx.prec == before


def test_the_command_says_the_same(found):
    ran = CliRunner().invoke(app, ["prove-orbits", "--stiffness", "1e5", "--json"])
    assert ran.exit_code == 0, ran.output
    assert json.loads(ran.stdout) == json.loads(json.dumps(found.to_dict()))


def test_motions_that_are_not_proven_say_why():
    # Of chaos, and beyond Eq. (3): so soft a contact has it below Eq. (8).
    soft = rattle.prove_orbits(Oscillator(0.6, 0.17, 0.6, stiffness=100.0), departures=200)
    assert not soft.contact.proven and "Eq. 3" in soft.contact.why and soft.contact.depth == 0.0
    assert "permanent contact: not proven, as it does not exist" in str(soft)
    told = soft.to_dict()
    json.dumps(told, allow_nan=False)
    for each in soft.orbits:
        assert each.proven == (each.why == "")


@pytest.mark.parametrize(
    ("machine", "arguments", "error", "why"),
    [
        (Oscillator(0.6, 0.1, 0.6), {}, InvalidJob, "finite stiffness"),
        (STIFF, {"departures": 0}, InvalidJob, "from 1 to 100000"),
        (STIFF, {"departures": 1.5}, InvalidJob, "whole number"),
        (Oscillator(0.6, 0.25, 0.6, stiffness=1e4), {}, OutsideDomain, "Eq. 8"),
    ],
)
def test_a_wrong_argument_is_named(machine, arguments, error, why):
    with pytest.raises(error, match=why):
        rattle.prove_orbits(machine, **arguments)


def test_the_command_refuses_with_a_reason():
    ran = CliRunner().invoke(app, ["prove-orbits", "--stiffness", "inf"])
    assert ran.exit_code == 2 and "finite stiffness" in ran.output.replace("\n", " ")
