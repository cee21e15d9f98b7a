"""The one door from these tests to the code: all that a reorganisation has to adapt is here.

The rest of the folder speaks HTTP, reads files, and knows no module of the project.
"""

import contextlib
import io
import sqlite3
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
import typer
from typer.testing import CliRunner

import rattle
from rattle.cli import app
from tests.running_service import running_service
from tests.service.idle_service import idle_service

DATABASE = "jobs.sqlite"


@contextlib.contextmanager
def idle(data):
    """A service that takes requests and runs none, with its data in a folder."""
    with pytest.MonkeyPatch.context() as patch, idle_service(patch, data) as service:
        yield service


def running(data):
    """A service that runs jobs, with its data in a folder."""
    return running_service(data)


def stored(data, job_id):
    """Kind, request as text, and digest of a job, as the database has them."""
    query = "SELECT kind, request, digest FROM jobs WHERE id = ?"
    with contextlib.closing(sqlite3.connect(Path(data) / DATABASE)) as database:
        kind, request, digest = database.execute(query, (job_id,)).fetchone()
    return {"kind": kind, "request": request, "digest": digest}


def store_folder(service, job):
    """Folder of a job's store."""
    return Path(service.store_of(job))


def command_line():
    """All of ``rattle`` as Click has it."""
    return typer.main.get_command(app)


def _said(*words):
    """What a command prints, or what it is refused with: words are not kept, but that it was refused is."""
    done = CliRunner().invoke(app, [str(word) for word in words])
    return done.stdout if done.exit_code == 0 else f"exit {done.exit_code}"


def drawn_by_shell(folder):
    """PNGs of `rattle plot`, which draws from the store, by the options that are given."""
    ways = ["", "--layer group", "--layer period", "--layer step", "--shares", "--overlay grazing,preimages,attractors"]
    return {way: _drawn(folder, way.split()) for way in ways}


def _drawn(folder, options):
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch) / "picture.png"
        said = _said("plot", folder, "--out", path, *options)
        return path.read_bytes() if path.exists() else said


def drawn_from_dataset(folder):
    """PNGs of `dataset.rattle`, which draws from the dataset, by the call."""
    calls = {
        "plot()": lambda result: result.plot(),
        "plot(layer='step')": lambda result: result.plot(layer="step"),
        "plot(overlays=[])": lambda result: result.plot(overlays=[]),
        "plot(palette='colour_blind')": lambda result: result.plot(palette="colour_blind"),
        "plot_shares()": lambda result: result.plot_shares(),
    }
    with rattle.open(str(folder)) as dataset:
        return {name: _rendered(call, dataset.rattle) for name, call in calls.items()}


def _rendered(call, result):
    plt.close("all")
    try:
        drawn = call(result)
    except (rattle.InvalidJob, ValueError, TypeError) as error:
        return type(error).__name__
    png = io.BytesIO()
    getattr(drawn, "figure", drawn).savefig(png, format="png", dpi=80)
    plt.close("all")
    return png.getvalue()


def tabled(folder):
    """CSV of `rattle table`, of what it lists by itself and of everything along a dimension."""
    with rattle.open(str(folder)) as dataset:
        names = [str(name) for name in dataset.sizes if name not in ("time", "velocity")]
    found = {
        name or "(by itself)": _said("table", folder, *(("--name", name) if name else ())) for name in ["", *names]
    }
    return {name: text for name, text in found.items() if not text.startswith("exit ")}


def measured(folder):
    """What `dataset.rattle` tells, by name; the name of the error where it tells nothing of this kind."""
    names = ["attractors", "colours", "levels", "shown", "cell_names", "image_counts", "oscillator"]
    calls = ["loudness", "measures", "least_disturbance"]
    with rattle.open(str(folder)) as dataset:
        result = dataset.rattle
        found = {name: _told(lambda name=name: getattr(result, name)) for name in names}
        found |= {name: _told(lambda name=name: getattr(result, name)()) for name in calls}
        return {name: _loaded(each) for name, each in found.items()}


def _told(ask):
    try:
        found = ask()
        return found() if callable(found) else found
    except (rattle.InvalidJob, ValueError, TypeError) as error:
        return type(error).__name__


def _loaded(found):
    if hasattr(found, "load"):
        return found.load()
    return found._asdict() if isinstance(found, rattle.Oscillator) else found
