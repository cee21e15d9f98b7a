"""The commands as a user types them."""

import dataclasses
import json
import shlex
import socket
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import typer
import xarray as xr
from matplotlib.figure import Figure
from typer.testing import CliRunner

from rattle.cli import _loaded, app, compute, remote
from rattle.cli.command import EXAMPLES
from rattle.cli.console import out
from rattle_paper import production, registry
from rattle_paper.figure import PaperFigure, Printed, Sheet
from tests.ports import free_port
from tests.waiting import wait_until
from worker.analyses.grazing_curves import GrazingCurveView
from worker.kinds import KINDS

SMALL = ["--cells", "24", "20", "--iterations", "101"]


def rattle(*arguments):
    """A command in a process of its own."""
    command = [sys.executable, "-c", "from rattle.cli import main; main()", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=90)


@pytest.mark.parametrize("command", typer.main.get_command(app).commands)
def test_every_command_explains_itself(command):
    answer = CliRunner().invoke(app, [command, "--help"])
    assert answer.exit_code == 0 and len(answer.output) > 200


def every_command():
    """Words of each command and the command itself, those of `rattle keys` as well."""
    for name in typer.main.get_command(app).commands:
        command = _loaded(name)
        yield [name], command
        yield from (([name, each], found) for each, found in getattr(command, "commands", {}).items())


EVERY_COMMAND = {" ".join(words): (words, command) for words, command in every_command()}


@pytest.mark.parametrize("asked", ["--help", "-h"])
@pytest.mark.parametrize("words", [[], *(words for words, _ in EVERY_COMMAND.values())], ids=" ".join)
def test_help_is_not_cut_at_80_columns_and_ends_with_examples(words, asked, monkeypatch):
    monkeypatch.setattr(out, "width", 80)
    monkeypatch.setenv("COLUMNS", "80")
    answer = CliRunner().invoke(app, [*words, asked], terminal_width=80)
    assert answer.exit_code == 0, answer.output
    assert "\N{HORIZONTAL ELLIPSIS}" not in answer.output and max(map(len, answer.output.splitlines())) <= 80
    assert "Example" in answer.output and answer.output.rstrip().splitlines()[-1].strip().startswith("rattle ")
    for parameter in EVERY_COMMAND[" ".join(words)][1].params if words else ():
        assert all(flag in answer.output for flag in parameter.opts if flag.startswith("--"))


@pytest.mark.parametrize("name", EVERY_COMMAND)
def test_examples_are_what_their_command_takes(name):
    words, command = EVERY_COMMAND[name]
    for example in EXAMPLES.get(words[-1], ()):
        called = shlex.split(example.partition("<")[0])
        if len(words) < len(called) and getattr(command, "commands", None) is None:
            assert called[: 1 + len(words)] == ["rattle", *words]
            command.make_context(name, called[1 + len(words) :])


@pytest.mark.parametrize(
    "name", ["serve", "basin", "sweep", "bifurcation", "orbits", "manifold", "grazing-curve", "check", "paper"]
)
def test_what_computes_takes_a_scheduler(name):
    (option,) = [each for each in EVERY_COMMAND[name][1].params if "--scheduler" in each.opts]
    assert option.envvar == "RATTLE_SCHEDULER" and option.show_envvar


def test_a_scheduler_that_is_named_is_asked(tmp_path, monkeypatch):
    monkeypatch.setattr("worker.cluster.connection._CONNECT_SECONDS", 0.1)
    address = f"tcp://127.0.0.1:{free_port()}"
    answer = CliRunner().invoke(app, ["basin", *SMALL, "--scheduler", address, "--out", str(tmp_path / "b.zarr")])
    assert answer.exit_code == 1 and f"no Dask scheduler answers at {address}" in answer.output


def test_one_number_of_cells_is_that_of_both_axes(tmp_path):
    store = tmp_path / "square.zarr"
    answer = CliRunner().invoke(app, ["basin", "--cells", "12", "--iterations", "101", "--out", str(store)])
    assert answer.exit_code == 0, answer.output
    with xr.open_zarr(store) as basin:
        assert basin.solution.shape == (12, 12)


def test_shares_of_a_sample_are_printed_with_their_errors(tmp_path):
    store = tmp_path / "shares.zarr"
    answer = CliRunner().invoke(app, ["basin", "--sample", "300", "--iterations", "101", "--out", str(store)])
    assert answer.exit_code == 0, answer.output
    with xr.open_zarr(store) as basin:
        share, error = float(basin.share[0]), float(basin.share_error[0])
    assert 0.0 < error < share and f"{100 * share:.3f} ± {100 * error:.2g} %" in answer.output


def test_jobs_are_readable_at_80_columns(monkeypatch, capsys):
    oscillator = {"model": "impacting", "damping": 0.6, "eccentricity": 0.1, "half_backlash": 0.6, "restitution": 1.0}
    progress = {"tiles_done": 3, "tiles_total": 12, "stage": "mapping"}
    job = {"id": "0123456789abcdef" * 2, "kind": "basin", "state": "running", "progress": progress,
           "created": "2026-01-02T03:04:05.678Z", "request": {"oscillator": oscillator}}  # fmt: skip
    monkeypatch.setattr(out, "width", 80)
    remote._print_jobs([job, job])
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 6 and max(map(len, lines)) <= 80
    assert lines[0].strip() == job["id"]
    assert lines[1].strip() == "basin, running, 3 of 12 tiles, 2026-01-02T03:04:05"
    assert lines[2].strip() == "damping 0.6, eccentricity 0.1, half_backlash 0.6, restitution 1"


@pytest.mark.parametrize("words", [["revoke", "nobody"], ["list"]])
def test_looking_at_keys_leaves_no_folder_behind(tmp_path, words):
    answer = CliRunner().invoke(app, ["keys", *words, "--data", str(tmp_path / "none")])
    assert answer.exit_code == (2 if "revoke" in words else 0), answer.output
    assert list(tmp_path.iterdir()) == []


def test_what_the_paper_prints_stands_beside_what_is_found(tmp_path, monkeypatch):
    sheet = Sheet(Figure(figsize=(1, 1)), {"point": {"damping": 0.59971576}})
    figure = PaperFigure("fig0", "", lambda *_: sheet, printed=(Printed("a fold", 0.5997, ("point", "damping")),))
    monkeypatch.setitem(registry.ALL_FIGURES, "fig0", figure)
    answer = CliRunner().invoke(app, ["paper", "fig0", "--out", str(tmp_path)])
    assert answer.exit_code == 0, answer.output
    (row,) = [line for line in answer.output.splitlines() if "a fold" in line]
    assert "0.5997 " in row and "0.59971576" in row
    beside = {"what": "a fold", "paper": 0.5997, "found": 0.59971576}
    assert json.loads((tmp_path / "fig0.json").read_text())["printed"] == [beside]


@pytest.mark.parametrize("name", ["fig10", "fig11"])
def test_kept_figures_have_what_the_paper_prints(name):
    kept = json.loads((Path(__file__).parents[3] / "docs" / "figures" / f"{name}.json").read_text())
    beside = [each.beside(kept) for each in registry.PAPER_FIGURES[name].printed]
    assert beside and kept["printed"] == beside
    assert all(each["found"] == pytest.approx(each["paper"], abs=1e-4) for each in beside)  # four digits are printed


def test_a_basin_is_computed_resumed_and_drawn_without_a_service(tmp_path):
    store, picture = tmp_path / "basin.zarr", tmp_path / "basin.png"
    done = rattle("basin", *SMALL, "--velocity", 0, 6, "--out", store)
    assert done.returncode == 0, done.stderr
    assert "permanent contact" in done.stdout and "P(1,1,0)" in done.stdout and "mapping: " in done.stdout
    with xr.open_zarr(store) as basin:
        assert basin.solution.shape == (20, 24) and float(basin.velocity[-1]) < 6.0
    assert "permanent contact" in rattle("basin", *SMALL, "--velocity", 0, 6, "--out", store).stdout
    other = rattle("basin", *SMALL, "--velocity", 0, 5, "--out", store)
    assert other.returncode == 1 and "holds the store of another request" in other.stderr
    assert rattle("plot", store, "--out", picture).returncode == 0
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.proof
@pytest.mark.timeout(400)  # the first proof compiles its kernels
def test_a_basin_is_proven_within_tolerances(tmp_path):
    proven = [
        "--cells",
        "8",
        "8",
        "--iterations",
        "101",
        "--prove",
        "--levels",
        "0",
        "--out",
        str(tmp_path / "it.zarr"),
    ]
    done = CliRunner().invoke(app, ["basin", *proven, "--tolerance", "damping=0.5999999:0.6000001"])
    assert done.exit_code == 0, done.output
    assert "%, proven: " in done.output
    with xr.open_zarr(tmp_path / "it.zarr", group="proof") as proof:
        assert proof.attrs["certificate"]["machine"]["damping"] == [0.5999999, 0.6000001]


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--prove", "--tolerance", "damping"], "damping=0.59:0.61"),
        (["--prove", "--tolerance", "damping=0.7:0.8"], "does not lie between"),
        (["--tolerance", "damping=0.59:0.61"], "prove"),
        (["--prove", "--levels", "5"], "levels"),
    ],
)
def test_a_proof_that_cannot_be_had_is_refused(options, told, tmp_path):
    done = CliRunner().invoke(app, ["basin", *options, "--out", str(tmp_path / "none.zarr")])
    assert done.exit_code == 2 and told in done.output, done.output
    assert not (tmp_path / "none.zarr").exists()


def test_a_motion_is_drawn_or_written_down_and_its_contacts_are_listed(tmp_path):
    start = ["trajectory", "--stiffness", "100", "--time", "0.3", "--velocity", "4", "--periods", "2"]
    drawn = CliRunner().invoke(app, [*start, "--out", str(tmp_path / "history.png")])
    assert drawn.exit_code == 0, drawn.output
    assert (tmp_path / "history.png").read_bytes().startswith(b"\x89PNG")
    lines = [line.split() for line in drawn.output.splitlines() if line.startswith("   ")]
    assert lines[0] == ["time", "wall", "what", "speed"]
    assert [line[1:3] for line in lines[1:]] == 2 * [["+1", "in"], ["+1", "out"]]
    assert "rattles on" in drawn.output
    written = CliRunner().invoke(app, [*start, "--out", str(tmp_path / "history.csv")])
    assert written.exit_code == 0, written.output
    table = (tmp_path / "history.csv").read_text().splitlines()
    assert table[0] == "time,displacement,velocity" and table[1] == "0.3,0.6,-4.0" and len(table) == 406


@pytest.mark.slow
def test_a_sweep_is_computed_and_drawn_without_a_service(tmp_path):
    store, picture = tmp_path / "sweep.zarr", tmp_path / "sweep.png"
    done = rattle("sweep", "--vary", "damping=0.55:0.65:3", *SMALL, "--out", store)
    assert done.returncode == 0, done.stderr
    assert "P(1,1,0)" in done.stdout and "between damping 0.55 and 0.6" in done.stdout
    assert "3 basins" in done.stdout
    with xr.open_zarr(store) as sweep:
        assert sweep.solution.shape == (3, 20, 24) and sweep.damping.values.tolist() == [0.55, 0.6, 0.65]
    for options in ([], ["--shares"], ["--layer", "step"]):
        assert rattle("plot", store, *options, "--out", picture).returncode == 0
        assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_a_figure_of_the_paper_is_drawn_and_its_numbers_written_down(tmp_path):
    done = rattle("paper", "fig4", "--out", tmp_path / "figures")
    assert done.returncode == 0, done.stderr
    assert "entering contact: " in done.stdout and "fig4.png is drawn" in done.stdout
    assert json.loads((tmp_path / "figures" / "fig4.json").read_text())["figure"] == "fig4"
    assert (tmp_path / "figures" / "fig4.png").read_bytes().startswith(b"\x89PNG")
    (tmp_path / "file").touch()
    refused = rattle("paper", "fig4", "--out", tmp_path / "file")
    assert refused.returncode == 1 and "cannot be written" in refused.stderr and "Traceback" not in refused.stderr


def test_an_interrupted_figure_says_that_the_same_command_goes_on(tmp_path, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(production, "produce", interrupted)
    answer = CliRunner().invoke(app, ["paper", "fig4", "--out", str(tmp_path)])
    assert answer.exit_code == 1 and "the same command goes on with the basins" in " ".join(answer.output.split())


@pytest.mark.slow
def test_a_manifold_is_grown_here_told_and_drawn(tmp_path):
    store, picture = tmp_path / "manifold.zarr", tmp_path / "manifold.png"
    command = ("manifold", "--saddle", "0.6,3.77", "--arclength", "1", "--out", store)
    done = rattle(*command)
    assert done.returncode == 0, done.stderr
    assert "P(1,1,0)" in done.stdout and "3.7699111843" in done.stdout and "as long as asked for" in done.stdout
    assert rattle("plot", store, "--out", picture).returncode == 0
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "code", "told"),
    [
        (["basin", "--eccentricity", "0.3", "--stiffness", "1e4", "--out", "x.zarr"], 2, "epsilon_crit1 = 0.189746"),
        (["basin", "--iterations", "1500", "--out", "x.zarr"], 2, "nearest: 1499 or 1511"),
        (["basin", "--velocity", "3", "2", "--out", "x.zarr"], 2, "velocity: stop must be above start = 3"),
        (["basin", "--damping", "nan", "--out", "x.zarr"], 2, "damping: Input should be a finite number"),
        (["basin"], 2, "--out"),
        (["trajectory", "--velocity", "4", "--out", "x.gif"], 2, "should end in .png, .svg, .pdf or .csv"),
        (["trajectory", "--velocity", "-4", "--out", "x.png"], 2, "velocity must be positive"),
        (["trajectory", "--velocity", "nan", "--out", "x.png"], 2, "velocity: Input should be a finite number"),
        (["trajectory", "--velocity", "1e9", "--out", "x.png"], 2, "velocity: Input should be less than or equal to 1"),
        (["basin", "--half-backlash", "1e-12", "--out", "x.zarr"], 2, "speeds must be at most 3.15598e-07, not 7"),
        (["trajectory", "--velocity", "4", "--periods", "nan", "--out", "x.png"], 2, "more than the limit"),
        (["trajectory", "--velocity", "4", "--stiffness", "0.01", "--out", "x.png"], 2, "above damping^2/8"),
        (
            ["trajectory", "--velocity", "4", "--stiffness", "100", "--eccentricity", "0.16", "--out", "x.png"],
            2,
            "epsilon_crit1 = 0.15263",
        ),
        (["trajectory", "--velocity", "4", "--out", "nowhere/x.png"], 1, "cannot be written"),
        (["basin", "--sample", "0", "--out", "x.zarr"], 2, "sample: Input should be greater than or equal to 1"),
        (["sweep", "--out", "x.zarr"], 2, "--vary"),
        (["sweep", "--vary", "damping", "--out", "x.zarr"], 2, "damping needs at least one value"),
        (["sweep", "--vary", "damping=0.5:0.6", "--out", "x.zarr"], 2, "how many, damping=0.5:0.7:21"),
        (["sweep", "--vary", "damping=0.5,-0.2", "--out", "x.zarr"], 2, "value 1 of damping"),
        (["plot", "nowhere.zarr", "--out", "x.png"], 1, "nowhere.zarr is no basin store"),
        (["bifurcation", "--vary", "damping=0.5:0.6", "--out", "x.zarr"], 2, "how many, damping=0.5:0.7:21"),
        (["bifurcation", "--vary", "damping=0.6", "--seed", "3", "--out", "x.zarr"], 2, "as in 0.6,3.77"),
        (["bifurcation", "--vary", "damping=0.6", "--seed", "0,-3", "--out", "x.zarr"], 2, "section of departures"),
        (["orbits", "--seed", "1", "--out", "x.zarr"], 2, "write phase, speed and impact period"),
        (["orbits", "--follow", "damping=0.7:0.8", "--out", "x.zarr"], 2, "bounds that hold its value 0.6"),
        (["orbits", "--follow", "damping", "--out", "x.zarr"], 2, "write damping=0.45:0.7"),
        (["manifold", "--saddle", "P(1,1)", "--out", "x.zarr"], 2, "an itinerary is P(m, n+, n-)"),
        (
            ["manifold", "--saddle", "0.6,3.77", "--arclength", "inf", "--out", "x.zarr"],
            2,
            "arclength: Input should be a finite number",
        ),
        (["grazing-curve", "--order", "-1", "--out", "x.zarr"], 2, "order must be 0"),
        (["plot", "nowhere.zarr", "--out", "x.gif"], 2, "ends in one of .png, .svg, .pdf"),
        (["table", "nowhere.zarr"], 1, "nowhere.zarr is no basin store"),
        (["submit", "nowhere.json"], 2, "nowhere.json cannot be read"),
        (["table", "nowhere.zarr", "--out", "x.xls"], 2, "ends in .csv or .json"),
        (["plot", "nowhere.zarr", "--overlay", "saddle", "--out", "x.png"], 2, "choose among proven,grazing,preimages"),
        (["paper", "fig99", "--out", "x"], 2, "choose one of fig1, fig2, fig3, fig4"),
        (["paper", "fig7", "--cells", "0", "10", "--out", "x"], 2, "at least one cell each way"),
        (["paper", "fig4"], 2, "--out"),
        (["submit", "nowhere.json"], 2, "nowhere.json cannot be read"),
        (["jobs", "--url", "http://127.0.0.1:9"], 1, "start one with `rattle serve`"),
        (["serve", "--host", "0.0.0.0"], 2, "no loopback address"),
        (["serve", "--port", "99999"], 2, "port: Input should be less than or equal to 65535, not 99999"),
        (["serve", "--data", "/proc/foo", "--port", "0"], 2, "/proc/foo cannot hold database and results"),
        (["keys", "add", "me", "--data", "/proc/foo"], 1, "the database does not open"),
        (["basin", "--damping", "0.5", "--damping", "0.6", "--out", "x.zarr"], 2, "--damping is given 2 times"),
        (
            ["bifurcation", "--vary", "damping=0.5:0.6:3", "--vary", "eccentricity=0:0.1:3", "--out", "x.zarr"],
            2,
            "--vary is given 2 times, and takes one value",
        ),
        (["sweep", "--vary", "half-backlash=0.6,0.5,0.7", "--out", "x.zarr"], 2, "values of half_backlash must ascend"),
        (["sweep", "--vary", "damping=0.5:0.7:0.05", "--out", "x.zarr"], 2, "and how many, damping=0.5:0.7:21"),
        (["basin", "--cells", "200.5", "--out", "x.zarr"], 2, "two numbers, as in --cells 200 150"),
        (["basin", "--out", "x.zarr", "--cells"], 2, "two numbers, as in --cells 200 150"),
        (["basin", "--cells", "200,150", "--out", "x.zarr"], 2, "two numbers, as in --cells 200 150"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line_without_a_traceback(tmp_path, monkeypatch, arguments, code, told):
    monkeypatch.chdir(tmp_path)
    answer = CliRunner().invoke(app, arguments)
    assert answer.exit_code == code, answer.output
    assert told in " ".join(answer.output.split()) and "Traceback" not in answer.output
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("last_whole", "code", "told"), [
    (3, 0, "is complete"),
    (1, 1, "orders 2 to 3 are incomplete: order 2 needs more points than a request may have; ask for --order 1,"),
    (2, 1, "order 3 is incomplete: order 3 needs more points than a request may have; ask for --order 2,"),
])  # fmt: skip
def test_orders_of_a_grazing_curve_that_are_incomplete_are_an_error(monkeypatch, last_whole, code, told):
    orders = [
        {"order": order, "complete": order <= last_whole, "pieces": 1, "vertices": 9, "arclength": 1.0}
        for order in range(4)
    ]
    monkeypatch.setattr(compute, "is_complete", lambda location, digest: True)
    found = GrazingCurveView(
        complete=True, request={}, pieces_done=0, seconds={"tracing": 1.0}, zarr="", kind="grazing_curve", orders=orders
    )
    kind = dataclasses.replace(KINDS["grazing_curve"], summarise=lambda location: found)
    monkeypatch.setattr(compute, "KINDS", {"grazing_curve": kind})
    answer = CliRunner().invoke(app, ["grazing-curve", "--order", "3", "--out", "there.zarr"])
    assert answer.exit_code == code, answer.output
    assert told in " ".join(answer.output.split())


def test_a_kind_that_is_no_verb_is_asked_for_by_its_request(monkeypatch, tmp_path):
    monkeypatch.setattr(compute, "KINDS", {**KINDS, "of_an_extension": KINDS["grazing_curve"]})
    request, store = tmp_path / "request.json", tmp_path / "curve.zarr"
    shell, asked = typer.Typer(), ["--request", str(request), "--out", str(store)]
    shell.command()(compute.compute_command("of_an_extension"))
    refused = CliRunner().invoke(shell, asked)
    assert refused.exit_code == 2 and "No such file" in " ".join(refused.output.split())
    request.write_text(json.dumps({"kind": "grazing_curve", "order": 0}))
    done = CliRunner().invoke(shell, asked)
    assert done.exit_code == 0 and "is complete" in " ".join(done.output.split()), done.output


def test_a_service_says_when_it_is_ready_and_where_its_data_are(service):
    log = service.data / "serve.log"
    wait_until("it says so", lambda: f"ready: {service.url}, " in log.read_text(), service.why_not)
    assert service.results in log.read_text() or f"data in {service.data}" in log.read_text()
    assert "/readyz" not in log.read_text()


def test_the_start_of_a_service_is_a_line_of_its_log(tmp_path, monkeypatch, caplog):
    caplog.set_level("INFO", "rattle.serve")
    monkeypatch.setattr("rattle.cli.serve.write_logs", lambda *_: None)
    monkeypatch.setattr("rattle.cli.serve.create_app", lambda settings: None)
    monkeypatch.setattr("rattle.cli.serve.Server", lambda *_, **__: SimpleNamespace(run=lambda: None))
    monkeypatch.setattr("rattle.cli.serve.signal.signal", lambda *_: None)
    port = str(free_port())
    answer = CliRunner().invoke(app, ["serve", "--port", port, "--data", str(tmp_path / "data")])
    assert answer.exit_code == 0 and answer.output == ""
    assert caplog.messages == [f"starting on http://127.0.0.1:{port}"]


def test_a_port_in_use_is_refused_before_anything_is_started(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = str(other.getsockname()[1])
        answer = CliRunner().invoke(app, ["serve", "--port", port, "--data", str(tmp_path / "data")])
    assert answer.exit_code == 1 and f"port {port} of 127.0.0.1 is in use" in answer.output
    assert list(tmp_path.iterdir()) == []


def test_a_service_is_asked_followed_and_listed(service, tmp_path):
    request = tmp_path / "request.json"
    request.write_text(json.dumps({"grid": {"time": {"cells": 16}, "velocity": {"cells": 16}}, "iterations": 211}))
    answer = CliRunner().invoke(app, ["submit", str(request), "--wait", "--url", service.url])
    assert answer.exit_code == 0, answer.output
    assert "permanent contact" in answer.output and "xarray.open_zarr(" in answer.output
    listed = CliRunner().invoke(app, ["jobs", "--json", "--url", service.url])
    newest = json.loads(listed.output)[0]
    assert newest["request"]["iterations"] == 211 and newest["state"] == "succeeded"
    stopped = CliRunner().invoke(app, ["cancel", newest["id"], "--url", service.url])
    assert stopped.exit_code == 0 and "succeeded" in stopped.output


def test_a_sweep_is_submitted_and_listed(service, tmp_path):
    request = tmp_path / "request.json"
    vary = [{"parameter": "damping", "values": [0.6, 0.65]}]
    grid = {"time": {"cells": 16}, "velocity": {"cells": 16}}
    # Like no other test's: a job that is there already may have been submitted too long ago to be listed.
    request.write_text(json.dumps({"vary": vary, "grid": grid, "iterations": 229}))
    answer = CliRunner().invoke(app, ["submit", str(request), "--wait", "--url", service.url])
    assert answer.exit_code == 0, answer.output
    listed = CliRunner().invoke(app, ["jobs", "--url", service.url]).output
    assert "damping 0.6 to 0.65 (2)" in listed


def test_a_refused_request_is_explained(service, tmp_path):
    request = tmp_path / "request.json"
    request.write_text('{"oscillator": {"model": "piecewise_linear", "stiffness": 1e4, "eccentricity": 0.2}}')
    answer = CliRunner().invoke(app, ["submit", str(request), "--url", service.url])
    assert answer.exit_code == 2 and "epsilon_crit1" in answer.output


def test_every_command_is_listed_as_it_describes_itself():
    listed = typer.main.get_command(app)
    for name, stand_in in listed.commands.items():
        _, command, _ = listed.resolve_command(None, [name])
        assert command.help.startswith(stand_in.help.rstrip(".")), name


def test_a_command_ends_without_a_search_for_garbage():
    """What is registered before is called after."""
    look = "import atexit, gc; atexit.register(lambda: print(gc.get_freeze_count() > 0)); from rattle.cli import main; "
    told = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.argv[1:] = ['--version']; {look} main()"],
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert told.stdout.split()[-1] == "True" and told.returncode == 0, told.stderr


def test_commands_that_only_ask_load_no_kernels_and_no_cluster():
    look = "import sys; from rattle.cli import app, remote; print({'numba', 'dask', 'matplotlib'} & set(sys.modules))"
    told = subprocess.run([sys.executable, "-c", look], capture_output=True, text=True, timeout=60)
    assert told.stdout.strip() == "set()", told.stdout + told.stderr
