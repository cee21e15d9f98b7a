"""``rattle transmission-error`` and ``--transmission-error``: the same forcing by options that are copied."""

import json
import math
import re
import shlex

import pytest
from typer.testing import CliRunner

from rattle.arguments import job_of
from rattle.cli import app
from rattle.cli.options import arguments_from, options_of
from rattle.verbs import basin

TWO_PI = 2.0 * math.pi


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "te.csv"
    rows = []
    for angle in range(0, 360, 5):
        turn = angle / 360
        rows.append(f"{angle},{10 * math.cos(TWO_PI * (turn - 0.1)) + 1.5 * math.cos(TWO_PI * 2 * turn)!r}")
    path.write_text("\n".join(["angle,error", *rows]))
    return path


def told(*words):
    answer = CliRunner().invoke(app, [str(word) for word in words])
    return answer.exit_code, answer.stdout, answer.stderr


def test_the_report_says_what_is_kept_and_left_out_and_the_options_to_copy(file, tmp_path):
    code, text, _ = told("transmission-error", file, "--unit", "degrees", "--scale", "0.01")
    assert code == 0
    assert "kept: order 1, 2, which explain 100 % of the variance" in text and "up to 35, scaled by 0.01" in text
    assert "t = 0 lies at 0.1 turns" in text and "Eq. (8) at damping 0.6 holds" in text
    options = shlex.split(text.splitlines()[-1])
    assert options == ["--eccentricity", "0.1", "--harmonic", "2:0.015:0.2"]
    histories = [tmp_path / "copied.csv", tmp_path / "measured.csv"]
    start = ["--velocity", 4, "--periods", 2]
    measured = ["--transmission-error", f"{file},unit=degrees,scale=0.01"]
    for path, forcing in zip(histories, (options, measured), strict=True):
        code, _, error = told("trajectory", *start, *forcing, "--out", path)
        assert code == 0, error
    assert histories[0].read_bytes() == histories[1].read_bytes()


def test_fewer_orders_are_kept_if_that_is_asked_for_and_json_has_all_numbers(file):
    code, text, _ = told(
        "transmission-error", file, "--unit", "degrees", "--scale", "0.03", "--explained", "0.9", "--json"
    )
    found = json.loads(text)
    assert code == 0 and found["eccentricity"] == pytest.approx(0.3) and found["harmonics"] == []
    assert found["left_out"]["order"] == 2 and found["left_out"]["amplitude"] == pytest.approx(0.045)
    # Eq. (7) with one harmonic: 4 pi delta - 2 pi eps sqrt(4 pi^2 + delta^2).
    least = 4 * math.pi * 0.6 - TWO_PI * 0.3 * math.hypot(TWO_PI, 0.6)
    assert found["least_acceleration"] == pytest.approx(least) and found["defined"] is False
    _, text, _ = told("transmission-error", file, "--unit", "degrees", "--scale", "0.03")
    assert "Eq. (8) at damping 0.6 does not hold" in text


def test_every_command_that_names_an_oscillator_takes_a_curve(file):
    values = {each.name: each.default for each in options_of(basin)}
    with_commas = file.rename(file.with_name("1,000 rpm=slow,te.csv"))
    values["transmission_error"] = f"{with_commas},unit=degrees,scale=0.01,explained=0.9"
    job = job_of("basin", arguments_from(basin, values))
    assert job.digest == job_of("basin", {"eccentricity": 0.1}).digest
    for command in ("basin", "sweep", "bifurcation", "orbits", "manifold", "grazing-curve", "trajectory"):
        _, text, _ = told(command, "--help")
        assert re.search(r"--transmission-err", text), command


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["transmission-error", "nowhere.csv"], "nowhere.csv cannot be read"),
        (["transmission-error", "FILE"], "They are read as turns"),
        (["transmission-error", "FILE", "--unit", "degrees", "--damping", "0"], "damping must be positive"),
        (["transmission-error", "FILE", "--columns", "a", "b"], "line 1: there is no column 'a'"),
        (["basin", "--out", "b.zarr", "--transmission-error", "FILE,scle=1"], "write te.csv,unit=degrees"),
        (["basin", "--out", "b.zarr", "--transmission-error", "FILE,scale=x"], "write te.csv,unit=degrees"),
        (
            ["basin", "--out", "b.zarr", "--transmission-error", "FILE,unit=degrees", "--harmonic", "2:0.01"],
            "the forcing is given twice",
        ),
        (
            ["trajectory", "--velocity", "4", "--out", "b.csv", "--transmission-error", "FILE,unit=degrees",
             "--eccentricity", "0.05"],
            "the forcing is given twice",
        ),
        # The default eccentricity was given, too.
        *((
            [*words, "--transmission-error", "FILE,unit=degrees", "--eccentricity", "0.1"], "the forcing is given twice"
        ) for words in (["basin", "--out", "b.zarr"], ["trajectory", "--velocity", "4", "--out", "b.csv"])),
        (["basin", "--out", "b.zarr", "--transmission-error", "a,b.csv,unit=degrees"], "a,b.csv cannot be read"),
        (["orbits", "--out", "b.zarr", "--transmission-error", "FILE,unit=degrees", "--stiffness", "9"], "Eq. 3"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_and_nothing_is_written(words, message, file, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, _, error = told(*(word.replace("FILE", str(file)) for word in words))
    assert code == 2 and message in error.replace("\n", " ")
    assert list(tmp_path.iterdir()) == [file]
