"""A preview shows what a job of the same cells and k would."""

import threading

import numpy as np
import pytest
import xarray as xr
from pydantic import ValidationError

from rattle_kernels import OutsideDomain
from rattle_kernels.attractors import attractor_search
from rattle_kernels.basins import preview
from worker.cluster.driver import Driver
from worker.errors import InvalidJob
from worker.jobs.basin_job import BasinJob
from worker.jobs.preview_request import PreviewRequest, preview_basin
from worker.run import run_job

WEAK = {
    "oscillator": {"damping": 0.05, "eccentricity": 0.008, "half_backlash": 0.05},
    "grid": {"velocity": {"stop": 0.6}},
}
CASES = {
    "chaos": {},
    "four motions": {"oscillator": {"damping": 0.575}},
    "a chaotic transient": {"oscillator": {"damping": 0.527}},
    "springs": {"oscillator": {"model": "piecewise_linear", "stiffness": 1000}},
    "little damped": WEAK,
    "a window": {"grid": {"time": {"start": 0.7, "stop": 1.1}, "velocity": {"start": 3, "stop": 4}}},
}
STIFF = {"model": "piecewise_linear", "stiffness": 1000}
LONG = "a chaotic transient", "little damped"


def request_of(body, cells=48, k=127):
    grid = {axis: {"cells": cells} | body.get("grid", {}).get(axis, {}) for axis in ("time", "velocity")}
    return body | {"grid": grid, "iterations": k}


def names_of(seen):
    return np.array([attractor.name for attractor in seen.attractors])[seen.solution]


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name in LONG else name for name in CASES]
)
def test_the_labels_are_those_of_the_basin_of_the_same_request(name, client, tmp_path):
    body = CASES[name]
    body = request_of(body)
    shown = preview_basin(PreviewRequest(**body))
    store = str(tmp_path / "basin.zarr")
    job = BasinJob.from_request(body)
    run_job(job, store, Driver(client), report=lambda _: None, cancel=threading.Event())
    with xr.open_zarr(store) as basin:
        computed = basin.name.values[basin.solution.values]
    np.testing.assert_array_equal(names_of(shown), computed)
    ends = {end for attractor in shown.attractors for end, _ in attractor.ends}
    assert shown.shares.sum() == pytest.approx(1.0)
    assert all(share > 0.0 or number in ends for number, share in enumerate(shown.shares))


def test_a_window_seen_before_or_not_has_the_same_solutions():
    whole, part = request_of({}), request_of(CASES["a window"], 20)
    first = preview_basin(PreviewRequest(**part | {"oscillator": {"damping": 0.61}}))
    preview_basin(PreviewRequest(**whole | {"oscillator": {"damping": 0.61}}))
    again = preview_basin(PreviewRequest(**part | {"oscillator": {"damping": 0.61}}))
    np.testing.assert_array_equal(first.solution, again.solution)
    assert [each.name for each in first.attractors] == [each.name for each in again.attractors]


@pytest.mark.parametrize("body", CASES.values(), ids=CASES)
def test_quick_names_are_those_of_the_basin_where_a_motion_has_settled(body, monkeypatch):
    body = request_of(body)
    # Nothing is known of the oscillator, as when it is seen for the first time.
    monkeypatch.setattr(preview, "_known", preview._Catalogues())
    quick = names_of(preview_basin(PreviewRequest(**body, quick=True)))
    full = names_of(preview_basin(PreviewRequest(**body)))
    settled = ~np.isin(quick, ["chaotic", "undecided"])
    assert settled.any() and (quick[settled] == full[settled]).all()
    assert ("chaotic" in quick) == any(name.startswith("chaotic") for name in full.ravel())


def test_quick_names_wait_for_no_ensemble(monkeypatch):
    def ensemble(*_):
        raise AssertionError("an ensemble takes a hundred times as long as a preview may")

    monkeypatch.setattr(attractor_search, "follow_ensemble", ensemble)
    oscillator = {"damping": 0.5999}
    assert "chaotic" in names_of(preview_basin(PreviewRequest(oscillator=oscillator, quick=True)))
    with pytest.raises(AssertionError):
        preview_basin(PreviewRequest(oscillator=oscillator))


def test_quick_names_know_what_was_found_before():
    body = {"oscillator": {"damping": 0.5998}}
    full = preview_basin(PreviewRequest(**body))
    np.testing.assert_array_equal(names_of(preview_basin(PreviewRequest(**body, quick=True))), names_of(full))


def test_without_a_word_it_is_128_cells_each_way_and_a_small_prime():
    checked = PreviewRequest().checked()
    assert checked.grid.shape == (128, 128) and checked.iterations == 127
    assert PreviewRequest(oscillator={"damping": 0.06, "eccentricity": 0.01}).checked().iterations == 1277
    assert PreviewRequest(grid={"time": {"stop": 0.5}}).checked().grid.time_cells == 128


def test_it_stops_where_it_is_asked_to():
    class Enough(Exception):
        pass

    def pause():
        raise Enough

    with pytest.raises(Enough):
        preview_basin(PreviewRequest(oscillator={"damping": 0.59}), pause)


@pytest.mark.parametrize(
    ("body", "error", "words"),
    [
        ({"iterations": 128}, InvalidJob, "1 or a prime"),
        ({"oscillator": STIFF | {"eccentricity": 0.5}}, OutsideDomain, "eccentricity"),
        ({"grid": {"velocity": {"start": 3, "stop": 2}}}, ValidationError, "velocity"),
        ({"oscillator": {"model": "piecewise_linear", "stiffness": 100, "eccentricity": 0.16}}, OutsideDomain, "allow"),
    ],
)
def test_what_cannot_be_computed_is_refused(body, error, words):
    with pytest.raises(error, match=words):
        preview_basin(PreviewRequest(**body))
