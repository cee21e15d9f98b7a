"""What a notebook's explorer opens with, what its traits take, and what it is answered; nothing is computed here."""

import json
from datetime import UTC, datetime, timedelta
from email.utils import parsedate_to_datetime

import pytest
from traitlets import TraitError

import rattle
import rattle_notebook.widget as widgets
from rattle_notebook.in_process import InProcess
from service import app as application
from service.records.job_record import JobState
from tests.service.idle_service import IdleRunner
from worker.errors import InvalidJob

PUMP = {"speed": 3000, "inertia": 1e-3, "drag_torque": 0.5, "base_radius": 0.05, "backlash": 1e-4}


@pytest.fixture(scope="module")
def here():
    """The application of this process, whose jobs nobody runs."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(application, "RunnerProcess", IdleRunner)
        opened = InProcess()
        patched.setattr(widgets, "in_process", lambda: opened)
        yield opened
        opened.close()


@pytest.fixture
def widget(here):
    return rattle.explore()


def told(widget, **seen):
    """Let the page tell what is seen, as its messages do."""
    widget.set_state(seen)


def test_it_is_answered_as_by_a_service(here):
    page = here.ask("GET", "/")
    assert page.status == 200 and b'src="explorer/js/main.js"' in page.body
    # What was compressed on the line is read, and says so.
    assert "content-encoding" not in page.headers
    assert abs(parsedate_to_datetime(page.headers["date"]) - datetime.now(UTC)) < timedelta(minutes=1)
    asked = {"grid": {"time": {"cells": 8}, "velocity": {"cells": 8}}, "iterations": 61, "quick": True}
    answer = here.ask("POST", "/v1/previews", {"content-type": "application/json"}, json.dumps(asked))
    assert answer.status == 200 and json.loads(answer.body)["time"]["cells"] == 8
    assert here.ask("GET", "/v1/jobs/nothing").status in (404, 422)
    assert here.ask("POST", "/v1/basins", {"content-type": "application/json"}, "{").status == 400


def test_each_message_is_answered_under_its_number(widget, monkeypatch):
    sent = []
    monkeypatch.setattr(widget, "send", lambda content, buffers: sent.append((content, buffers)))
    widget._answer(
        widget, {"id": "a-1", "method": "GET", "path": "/explorer/kinds.json", "headers": {}, "body": None}, []
    )
    [(content, [body])] = sent
    assert (content["id"], content["status"]) == ("a-1", 200) and "basin" in json.loads(body)


def test_it_opens_with_what_is_given(here, tmp_path):
    assert rattle.explore()._opening == {}
    stiff = rattle.Oscillator(damping=0.7, stiffness=1e4, harmonics=((2, 0.01, 0.25),))
    asked = rattle.explore(stiff)._opening["request"]
    assert rattle.BasinJob.from_request(asked).oscillator == stiff
    assert asked["grid"]["velocity"]["stop"] == pytest.approx(8.4), "the window follows the machine"
    pump = rattle.GearPair(**PUMP, transmission_error={1: 2e-5})
    assert "machine" in rattle.explore(pump)._opening["request"]


def test_a_result_that_lies_here_is_a_job_at_once(here, tmp_path):
    basin = rattle.basin(cells=12, store=tmp_path / "basin.zarr", progress=False)
    opening = rattle.explore(basin)._opening
    assert opening["request"] == basin.rattle.request
    assert here._app.state.jobs.get(opening["job"]).state == JobState.QUEUED
    widget = rattle.explore(rattle.open(tmp_path / "basin.zarr"))
    assert widget._opening == opening, "it is adopted once"
    told(widget, job=opening["job"])
    assert widget.result.rattle.complete and (widget.result.solution == basin.solution).all()
    assert rattle.explore().result is None


def test_a_part_of_a_result_opens_the_whole_and_one_of_nowhere_its_request(here, tmp_path):
    basin = rattle.basin(cells=12, store=tmp_path / "basin.zarr", progress=False)
    assert rattle.explore(basin.isel(time=slice(4)))._opening == rattle.explore(basin)._opening
    assert rattle.explore(basin.drop_encoding())._opening == {"request": basin.rattle.request}


def test_what_cannot_be_shown_says_why(here, tmp_path):
    with pytest.raises(InvalidJob, match="a result, an Oscillator or a GearPair, not str"):
        rattle.explore("basin.zarr")
    with pytest.raises(InvalidJob, match="a trajectory has no page"):
        rattle.explore(rattle.trajectory(time=0.5, velocity=3.0))
    curve = rattle.grazing_curve(order=0, progress=False)
    assert "job" in rattle.explore(curve)._opening
    with pytest.raises(InvalidJob, match="not in a folder here"):
        rattle.explore(curve.drop_encoding())


def test_its_oscillator_is_that_of_the_page_and_the_other_way_round(widget):
    widget.oscillator = rattle.Oscillator(damping=0.7)
    assert widget._oscillator == {"model": "impacting", "damping": 0.7, "eccentricity": 0.1, "half_backlash": 0.6}
    loose = {
        "model": "piecewise_linear", "damping": 0.5, "eccentricity": 0.3, "half_backlash": 0.6, "stiffness": 1000.0,
        "allow_no_quiet_solution": True,
    }  # fmt: skip
    told(widget, _oscillator=loose)
    assert widget.oscillator.is_loose and widget.oscillator.stiffness == 1000.0
    assert widget._oscillator == loose, "what the page has said is not corrected"
    widget.oscillator = None
    assert widget._oscillator is None


def test_what_is_no_view_is_refused(widget):
    widget.window = (0.25, 0.5, 1, 2)
    widget.departure, widget.solution = (0.5, 3), "chaotic"
    for wrong in ((0.5, 0.25, 1, 2), (0, 1, 2, 2), (0, 1, 0, float("inf"))):
        with pytest.raises(TraitError, match="a window is t0 < t1, v0 < v1"):
            widget.window = wrong
    with pytest.raises(TraitError):
        widget.departure = (0.5,)
    with pytest.raises(ValueError, match="damping must be positive"):
        widget.oscillator = rattle.Oscillator(damping=-1)
    assert (widget.window, widget.departure) == ((0.25, 0.5, 1.0, 2.0), (0.5, 3.0))


def test_an_address_that_is_set_before_anything_is_seen_holds_all_of_the_view(widget):
    widget.oscillator, widget.solution = rattle.Oscillator(damping=0.7), "chaotic"
    widget.address = "?damping=0.65"
    assert (widget.oscillator, widget.solution) == (None, None)
    widget.departure = (0.5, 3.0)
    assert (widget.address, widget.departure) == ("?damping=0.65", (0.5, 3.0))
    told(widget, history=["widget.address = ..."], address="?damping=0.6", departure=[0.25, 3.0], solution="chaotic")
    assert (widget.departure, widget.solution) == ((0.25, 3.0), "chaotic")


def test_without_its_parts_it_says_which_extra_has_them(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(ImportError, match=r"pip install 'gear-rattle\[notebook\]'"):
        rattle.explore()
