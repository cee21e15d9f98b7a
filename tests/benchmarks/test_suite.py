"""The suite of benchmarks: its inputs are the same everywhere, and it finds answers that are wrong."""

import json
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from typer.testing import CliRunner

from benchmarks.suite import measuring
from benchmarks.suite.command import app, chosen, faults
from benchmarks.suite.exact import exact_image
from benchmarks.suite.measuring import measure, measure_all
from benchmarks.suite.methods import METHODS, PLAIN, Method, hulls, images, plain_ends, plain_images
from benchmarks.suite.report import Failed, Measured, Missing, read_run
from benchmarks.suite.showing import _rate, _times, draw, tables
from benchmarks.suite.workloads import (
    APPLICATIONS,
    OSCILLATOR,
    QUIET,
    RATTLES,
    WORKLOADS,
    Departures,
    checksum,
    ends_of,
    thin,
)
from rattle_kernels import CellGrid, next_impacts
from tests.documents.blocks import ROOT, blocks_of

PAGE = ROOT / "docs" / "benchmarks.md"
FEW = 25


def printed(run, beside=None):
    console = Console(width=80)
    with console.capture() as told:
        console.print(*tables(run, beside), sep="\n")
    return told.get()


@pytest.fixture(scope="module")
def run():
    """A run of the plain methods with few inputs."""
    return measure_all(chosen([PLAIN]), repeat=2, thinner=FEW)


@pytest.mark.parametrize("workload", WORKLOADS.values(), ids=WORKLOADS)
def test_inputs_are_those_of_their_checksum_which_the_page_prints(workload):
    workload.check_inputs()
    assert f"`{workload.sha256}`" in PAGE.read_text()


def test_departures_and_boxes_are_made_of_integers():
    departures, boxes = WORKLOADS["applications"].inputs, WORKLOADS["boxes"].inputs.edges
    for i in (1, 2, 250_000):
        a, b = (step * i % 2**32 for step in (3242174889, 2447445413))
        assert Fraction(departures.t[i - 1]) == Fraction(a, 2**32)
        assert Fraction(departures.v[i - 1]) == Fraction(7 * b, 2**32)
        column, row = a // 2**20, b // 2**20
        edges = Fraction(column, 4096), Fraction(column + 1, 4096), Fraction(7 * row, 4096), Fraction(7 * row + 7, 4096)
        assert tuple(map(Fraction, boxes[i - 1])) == edges


@pytest.mark.parametrize("every", [1, 5, 25, 125])
def test_a_thinned_panel_has_the_centres_of_a_coarser_grid(every):
    panel, side = WORKLOADS["basin"].part(every), 1000 // every
    grid = CellGrid(time_cells=side, velocity_cells=side)
    np.testing.assert_allclose(panel.times, grid.time_centres(), rtol=1e-15)
    np.testing.assert_allclose(panel.speeds, grid.velocity_centres(), rtol=1e-15)
    assert WORKLOADS["basin"].items(panel) == side**2


def test_thinning_twice_is_thinning():
    square = np.arange(50 * 50).reshape(50, 50)
    np.testing.assert_array_equal(thin(thin(square, 5, 2), 5, 2), thin(square, 25, 2))


def test_other_inputs_are_refused(monkeypatch):
    workload = replace(WORKLOADS["applications"], make=lambda: Departures(np.full(5, 0.5), np.ones(5)))
    monkeypatch.setitem(measuring.WORKLOADS, "applications", workload)
    with pytest.raises(ValueError, match=f"'applications' are not the suite's.*{checksum(workload.inputs)}"):
        measure_all(chosen([PLAIN]), repeat=1)


def test_known_images_are_exact():
    workload = WORKLOADS["applications"]
    part, known = workload.part(workload.known), workload.answer
    compared = np.flatnonzero(~np.isnan(known[:, 0]))
    assert (known.shape[0], compared.size) == (400, 400 - 132)
    for k in compared[:2]:
        assert exact_image(part.t[k], part.v[k], APPLICATIONS) == tuple(known[k])


@pytest.mark.parametrize(
    "method", [each for each in METHODS if not each.missing], ids=lambda method: f"{method.workload}, {method.name}"
)
def test_each_installed_method_agrees_with_the_known_answers(method):
    told = measure(method, WORKLOADS[method.workload], repeat=1, thinner=FEW)
    assert told.agrees, told


def test_ends_are_those_of_the_definition():
    """Departures that a map moves on in turns of one and of three, moves about, makes slow, and keeps in contact."""

    def apply(t, v, applications):
        turns, moves = v == 3.0, v == 5.0
        t = (t + applications * np.where(turns, 1.0 / 3.0, np.where(moves, 0.1234, 0.0))) % 1.0
        return Departures(t, np.where(v == 2.0, 0.01, np.where(v == 4.0, np.nan, v)))

    ends = ends_of(apply, Departures(np.full(5, 0.5), np.array([1.0, 2.0, 3.0, 4.0, 5.0])))
    assert ends.tolist() == [1, QUIET, 3, QUIET, RATTLES]
    assert ends_of(apply, Departures(np.full(1, 0.5), np.array([2.0]))).tolist() == [QUIET]


def _some_ends_exchanged(panel):
    ends = plain_ends(panel)
    ends[::8] = RATTLES - ends[::8]
    return ends


def _one_application_fewer(departures):
    return np.stack(next_impacts(OSCILLATOR, *departures, APPLICATIONS - 1)[:2], axis=1)


WRONG = {
    "images of another departure": ("applications", lambda inputs: np.roll(images(inputs), 1, axis=0)),
    "one application fewer": ("applications", _one_application_fewer),
    "phases that are off by 1e-7": ("applications", lambda inputs: images(inputs) + [1e-7, 0.0]),
    "speeds that are off by 1e-7": ("applications", lambda inputs: images(inputs) * [1.0, 1.0 + 1e-7]),
    "no images": ("applications", lambda inputs: images(inputs) * np.nan),
    "other ends": ("basin", _some_ends_exchanged),
    "enclosures elsewhere": ("boxes", lambda inputs: hulls(inputs) + [0.1, 0.1, 0.0, 0.0]),
    "wide enclosures": ("boxes", lambda inputs: hulls(inputs) + [-0.1, 0.1, 0.0, 0.0]),
    "no enclosures": ("boxes", lambda inputs: hulls(inputs) * np.nan),
}


@pytest.mark.parametrize("planted", WRONG)
def test_a_wrong_answer_is_found_and_has_no_rate(planted):
    workload, compute = WRONG[planted]
    wrong = Method("wrong", workload, compute, every=25)
    plain = [method for method in chosen([workload]) if method.name == PLAIN]
    run = measure_all([*plain, wrong], repeat=1)
    told = run.workloads[workload].methods["wrong"]
    assert not told.agrees and told.times_plain is None and run.measured(workload, "wrong") is None
    assert [line.split(" is wrong")[0] for line in faults(run)] == [f"{workload}, wrong"]
    (row,) = (line for line in printed(run).splitlines() if line.strip().startswith("wrong"))
    assert row.split()[:2] == ["wrong", "wrong"]


@pytest.mark.parametrize("workload", ["applications", "basin"])
def test_an_answer_of_another_shape_is_refused(workload):
    told = measure_all([Method("short", workload, lambda inputs: np.zeros((1, 2)))], repeat=1, thinner=FEW)
    (fault,) = faults(told)
    assert fault.startswith(f"{workload}, short failed: ValueError: ") and fault.endswith("not shape (1, 2)")


def test_what_is_not_installed_and_what_fails_is_said_and_the_others_run(tmp_path):
    def fails(inputs):
        raise RuntimeError("no convergence")

    methods = [
        Method("absent", "applications", images, needs=("no_such_package", "numpy")),
        Method("failing", "applications", fails),
        *(method for method in chosen([PLAIN]) if method.workload == "applications"),
    ]
    run = measure_all(methods, repeat=1, thinner=FEW)
    told = run.workloads["applications"].methods
    assert told["absent"] == Missing(not_installed=["no_such_package"])
    assert told["failing"] == Failed(failed="RuntimeError: no convergence")
    assert told[PLAIN].agrees and told[PLAIN].times_plain == 1.0
    assert "not installed" in printed(run) and "failed" in printed(run)
    assert faults(run) == ["applications, failing failed: RuntimeError: no convergence"]
    draw([run], tmp_path / "run.png")


def test_a_run_is_read_back_and_shown_beside_itself(run, tmp_path):
    path = tmp_path / "run.json"
    path.write_text(run.model_dump_json())
    again = read_run(path)
    assert again == run and again.versions["numpy"] == np.__version__
    for name, results in run.workloads.items():
        told = results.methods[PLAIN]
        assert len(told.seconds) == 2 and told.best == min(told.seconds)
        assert told.units_per_second == told.units / told.best
        # The fastest of this run is that of the other.
        assert f" {told.units_per_second / told.units_per_second:.3g} " in printed(run, again), name
    draw([run, again], tmp_path / "run.png")
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")


def test_a_run_beside_may_have_other_methods(run, tmp_path):
    beside = read_run(_example(tmp_path))
    told = printed(run, beside)
    (row,) = (line for line in told.splitlines() if "my-project" in line)
    assert row.split()[1:] == ["100,000,000"]
    draw([run, beside], tmp_path / "run.png")


def _example(folder):
    (block,) = (block for block in blocks_of(PAGE) if block.language == "json")
    (folder / "example.json").write_text(block.text)
    return folder / "example.json"


@pytest.fixture
def files(tmp_path, monkeypatch):
    """A folder with files that are no runs."""
    monkeypatch.chdir(tmp_path)
    told = json.loads(_example(tmp_path).read_text())
    told["workloads"]["applications"]["sha256"] = "0" * 64
    Path("other_inputs.json").write_text(json.dumps(told))
    del told["workloads"]["applications"]["methods"]["my-project"]["units"]
    Path("incomplete.json").write_text(json.dumps(told))
    Path("empty.json").write_text("{}")
    Path("text.json").write_text("units per second")
    Path("folder.json").mkdir()


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize(
    ("options", "answer"),
    [
        (["--only", "fast"], "--only: 'fast' is neither a workload ('applications', 'basin'"),
        (["--only", "boxes", "--only", "plain"], "--only: none of these methods does any of these workloads"),
        (["--repeat", "0"], "'--repeat': Input should be greater than or equal to 1"),
        (["--out", "run.txt"], "--out: a file whose name ends in .json is needed, not run.txt"),
        (["--out", "folder.json"], "--out: folder.json cannot be written: Is a directory"),
        (["--out", "text.json/run.json"], "cannot be written: "),
        (["--beside", "none.json"], "--beside: none.json cannot be read: No such file or directory"),
        (["--beside", "text.json"], "--beside: text.json is not JSON: "),
        (["--beside", "empty.json"], "--beside: empty.json is no run of the suite: format: Field required"),
        (["--beside", "incomplete.json"], "workloads.applications.methods.my-project.Measured.units: Field required"),
        (["--beside", "other_inputs.json"], "its inputs of 'applications' are not the suite's"),
    ],
)  # fmt: skip
def test_bad_options_and_files_are_refused_with_the_reason(options, answer):
    told = CliRunner().invoke(app, options)
    assert told.exit_code == 2
    assert answer in " ".join(told.output.replace("│", " ").split())


def test_the_command_writes_json_and_picture_and_prints_the_run_beside(tmp_path):
    out = tmp_path / "new" / "run.json"
    options = ["--only", "plain", "--only", "applications", "--quick", "--repeat", "1", "--out", str(out)]
    told = CliRunner().invoke(app, [*options, "--beside", str(_example(tmp_path))])
    assert told.exit_code == 0, told.output
    assert "beside: A processor, 8 cores, 2026-11-29" in told.output and "100,000,000" in told.output
    assert list(read_run(out).workloads) == ["applications"]
    assert out.with_suffix(".png").read_bytes().startswith(b"\x89PNG")


def test_the_command_fails_where_an_answer_is_wrong(tmp_path, monkeypatch):
    wrong = Method(PLAIN, "applications", lambda inputs: plain_images(inputs) + [0.5, 0.0], every=25)
    monkeypatch.setattr("benchmarks.suite.command.METHODS", [wrong])
    told = CliRunner().invoke(app, ["--quick", "--repeat", "1", "--out", str(tmp_path / "run.json")])
    assert told.exit_code == 1
    assert "applications, plain is wrong: error 5.0e-01, where 1.0e-08 is allowed" in " ".join(told.output.split())


def test_the_pages_python_runs_as_printed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (block,) = (block for block in blocks_of(PAGE) if block.language == "python")
    before = list(METHODS)
    try:
        exec(compile(block.text, PAGE.name, "exec"), {"__name__": "__main__"})
    finally:
        METHODS[:] = before
    told = read_run(tmp_path / "mine.json").workloads["applications"].methods
    assert set(told) == {"mine", PLAIN} and all(isinstance(each, Measured) and each.agrees for each in told.values())
    assert told["mine"].error == told[PLAIN].error


def test_the_page_names_each_workload_and_method():
    text = PAGE.read_text()
    for name in {*WORKLOADS, *(method.name for method in METHODS)}:
        assert f"`{name}`" in text, name


def test_the_pages_results_are_those_of_the_runs_beside_it():
    rows = {}
    for row in PAGE.read_text().split("\n## Results\n")[1].split("\n## ")[0].splitlines():
        if row.startswith("| ") and not row.startswith("| work"):
            work, method, *told = (cell.strip(" `") for cell in row.strip("|").split("|"))
            rows[work, method] = told
    runs = [read_run(ROOT / "docs" / f"benchmarks-zen-{generation}.json") for generation in (5, 4)]
    methods = [(work, name) for work, results in runs[0].workloads.items() for name in results.methods]
    found = {each: [run.measured(*each) for run in runs] for each in methods}
    assert all(all(measured) for measured in found.values())
    assert rows == {
        each: [cell(told) for told in measured for cell in (_rate, lambda told: _times(told.times_plain))]
        for each, measured in found.items()
    }
    assert all(f"{run.date}, [" in PAGE.read_text() for run in runs)
    assert len({run.processor for run in runs}) == 2
    run, other = runs
    assert {name: results.sha256 for name, results in other.workloads.items()} == {
        name: results.sha256 for name, results in run.workloads.items()
    }
    for name, results in run.workloads.items():
        assert results.sha256 == WORKLOADS[name].sha256
