"""A measured transmission error by the front door: a file or arrays, and into any verb."""

import numpy as np
import pytest

import rattle
from rattle.arguments import job_of

TURNS = np.arange(48) / 48
MICROMETRES = 5.0 + 10.0 * np.cos(2 * np.pi * (TURNS - 0.1)) + 2.0 * np.cos(4 * np.pi * TURNS)
SAMPLES = list(zip(TURNS.tolist(), MICROMETRES.tolist(), strict=True))
FORCING = {"eccentricity": 0.1, "harmonics": [(2, 0.02, 0.2)]}


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "te.csv"
    rows = [f"{error!r},{360 * turn!r}" for turn, error in SAMPLES]
    path.write_bytes("\r\n".join(["# one-flank test", "", "error,angle", *rows]).encode())
    return path


def test_a_file_and_arrays_give_the_same_forcing(file):
    read = rattle.transmission_error(file, unit="degrees", scale=0.01)
    assert read.forcing == rattle.transmission_error(TURNS, MICROMETRES, scale=0.01).forcing
    assert read.forcing == {"eccentricity": 0.1, "harmonics": ((2.0, 0.02, 0.2),)}
    assert read.shift == pytest.approx(0.1, abs=1e-12) and read.left_out.rms < 1e-12


def test_a_file_may_be_numbers_alone_or_name_other_columns(tmp_path):
    path = tmp_path / "te.csv"
    rows = [f"{turn!r}, {error!r}" for turn, error in SAMPLES]
    path.write_text("\n".join(rows))
    expected = rattle.transmission_error(TURNS, MICROMETRES).forcing
    assert rattle.transmission_error(path).forcing == expected
    path.write_text("\ufeff" + "\n".join(["theta,te", *rows]), encoding="utf-8")
    assert rattle.transmission_error(path, columns=("theta", "te")).forcing == expected


@pytest.mark.slow
def test_it_goes_into_any_verb_as_forcing_as_a_value_or_as_a_file(file, tmp_path):
    error = rattle.transmission_error(file, unit="degrees", scale=0.01)
    expected = job_of("basin", FORCING | {"damping": 0.8}).digest
    assert job_of("basin", {**error.forcing, "damping": 0.8}).digest == expected
    assert job_of("basin", {"transmission_error": error, "damping": 0.8}).digest == expected
    (tmp_path / "turns.csv").write_text("\n".join(f"{turn!r},{0.01 * size!r}" for turn, size in SAMPLES))
    given = {"transmission_error": tmp_path / "turns.csv", "damping": 0.8}
    assert job_of("basin", given).digest == expected
    motions = [
        rattle.trajectory(velocity=4.0, periods=2.0, damping=0.8, **given)
        for given in ({"transmission_error": error}, FORCING)
    ]
    assert motions[0].identical(motions[1])


def test_its_numbers_can_be_swept(file):
    error = rattle.transmission_error(file, unit="degrees", scale=0.01)
    swept = {"transmission_error": error, "damping": 0.8, "phase_2": (0, 1, 5), "cells": 10}
    assert job_of("sweep", swept).oscillator.parameters[-2:] == ("amplitude_2", "phase_2")
    over = {"transmission_error": error, "damping": 0.8, "eccentricity": [0.05, 0.06], "cells": 10}
    assert [each.parameter for each in job_of("sweep", over).vary] == ["eccentricity"]


@pytest.mark.parametrize("other", [{"eccentricity": 0.1}, {"harmonics": [(2, 0.01)]}, {"harmonics": []}])
def test_two_kinds_of_forcing_at_once_are_refused(other):
    error = rattle.transmission_error(TURNS, MICROMETRES, scale=0.01)
    with pytest.raises(ValueError, match="the forcing is given twice"):
        rattle.basin(transmission_error=error, **other)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "line 1: there are no samples"),
        ("# nothing\nangle,error\n", "line 1: there are no samples"),
        ("angle,err\n0,1\n", "line 1: there is no column 'error'; there are 'angle', 'err'"),
        ("# a\nturn,error\n0,1\n", "line 2: there is no column 'angle'"),
        ("angle,error\n0,1\n0.3,x\n", "line 3: an angle and an error are expected, not '0.3,x'"),
        ("angle,error\n0,1\n0.3\n", "line 3: an angle and an error are expected, not '0.3'"),
        ("angle,error\n0,1\n\n0.3,2\n0.2,3\n", "line 5: angle must increase: 0.2 follows 0.3"),
        ("angle,error\n0,1\n0.3,nan\n0.6,3\n", "line 3: error must be finite"),
        ("angle,error\n0,1\n0.3,2\n", "te.csv: a curve needs at least three samples, not 2"),
        ("angle,error\n0,1\n1,2\n2,3\n", "read as turns"),
        ("\xff\xfe", "is no CSV file"),
    ],
)
def test_what_is_wrong_with_a_file_is_named_with_its_line(tmp_path, text, told):
    path = tmp_path / "te.csv"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(ValueError, match=told) as refused:
        rattle.transmission_error(path)
    assert str(path) in str(refused.value)


def test_what_is_no_curve_is_refused(tmp_path):
    with pytest.raises(ValueError, match="cannot be read: No such file"):
        rattle.transmission_error(tmp_path / "nowhere.csv")
    with pytest.raises(ValueError, match="give angles and errors, or the path of a CSV file"):
        rattle.transmission_error(TURNS)
    with pytest.raises(ValueError, match="is a file, which has its errors"):
        rattle.transmission_error("te.csv", MICROMETRES)
