"""What a chaotic transient ends in, from its store to everything that lists motions."""

import shutil

import matplotlib.pyplot as plt
import numpy as np
import pytest
import zarr

import rattle
from rattle.cli.console import out
from rattle.cli.result_tables import print_solutions
from rattle_kernels import CellGrid, Oscillator
from service.models.results import OutlineView, PreviewView
from tests.worker.basins.test_pipeline import run
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.preview_request import PreviewRequest, preview_basin
from worker.jobs.swept_parameter import SweptParameter
from worker.motion_words import ends_in_words
from worker.results.summary import summarise
from worker.results.viewer import outline_basin
from worker.stores.basin_store import BasinStore
from worker.stores.layout import ENDS

OSCILLATOR = Oscillator(0.532864758213935, 0.08051199076214174, 0.5340363492127678)
GRID = CellGrid(time_cells=16, velocity_cells=16)
# A machine without a transient, and again the one with it: there its end has another number than in its own catalogue.
DAMPINGS = 0.45, OSCILLATOR.damping
TRANSIENT, END = "chaotic transient", "P(4,4,2)"


@pytest.fixture(scope="module")
def alone(client, tmp_path_factory):
    location = tmp_path_factory.mktemp("transient") / "basin.zarr"
    run(BasinJob(oscillator=OSCILLATOR, grid=GRID, iterations=499), location, client)
    return location


@pytest.fixture(scope="module")
def swept(client, tmp_path_factory):
    location = tmp_path_factory.mktemp("transient") / "sweep.zarr"
    vary = (SweptParameter("damping", DAMPINGS),)
    run(SweepJob(oscillator=OSCILLATOR, grid=GRID, iterations=499, vary=vary), location, client)
    return location


def ends_by_name(listed):
    names = [each.name for each in listed]
    return {each.name: [(names[number], share) for number, share in each.ends] for each in listed if each.ends}


def told_ends(summary):
    """The same of a summary."""
    listed, names = summary.solutions, [each.name for each in summary.solutions]
    return {each.name: [(names[end.solution], end.share) for end in each.ends] for each in listed if each.ends}


def test_a_transient_names_its_end_wherever_motions_are_listed(alone):
    expected = {TRANSIENT: [(END, 1.0)]}
    assert told_ends(summarise(str(alone))) == expected
    assert ends_by_name(outline_basin(str(alone), 0).solutions) == expected
    basin = rattle.open(alone)
    assert ends_by_name(basin.rattle.catalogue()) == expected
    table = basin.rattle.to_table()
    assert dict(zip(table.name, table.ends_in, strict=True))[TRANSIENT] == f"ends in {END}"
    assert set(table.ends_in) == {"", f"ends in {END}"}
    (row,) = basin.rattle.to_table("transient_ends").to_dict("records")
    assert (row["name"], row["ends_in"], row["transient_ends"]) == (TRANSIENT, END, 1.0)
    texts = [text.get_text() for text in basin.rattle.plot().get_legend().get_texts()]
    assert [text.split("\n")[1] for text in texts if text.startswith(TRANSIENT)] == [f"ends in {END}"]
    plt.close("all")


def test_results_over_http_and_the_shell_name_the_end(alone):
    result = summarise(str(alone)).model_dump(mode="json")
    names = [solution["name"] for solution in result["solutions"]]
    (transient,) = (solution for solution in result["solutions"] if solution["ends"])
    assert transient["name"] == TRANSIENT
    assert [(names[end["solution"]], end["share"]) for end in transient["ends"]] == [(END, 1.0)]
    # Laplace's rule for 64 of 64: 65/66 and 1/66, over 67.
    assert transient["ends"][0]["standard_error"] == pytest.approx((65 / 66**2 / 67) ** 0.5)
    drawn = OutlineView.from_outline(outline_basin(str(alone), 0)).solutions
    assert [drawn[end.solution].name for each in drawn for end in each.ends] == [END]
    with out.capture() as printed:
        print_solutions(result["solutions"])
    assert f"ends in {END}" in " ".join(printed.get().replace("│", " ").split())


def test_in_a_sweep_each_basin_has_its_own_ends_by_the_numbers_of_all(swept):
    dataset = rattle.open(swept)
    assert dataset.transient_ends.dims == ("damping", "attractor", "end")
    assert np.isnan(dataset.transient_ends.values[0]).all()
    assert ends_by_name(dataset.rattle.basin(damping=DAMPINGS[1]).rattle.catalogue()) == {TRANSIENT: [(END, 1.0)]}
    assert told_ends(summarise(str(swept))) == {TRANSIENT: [(END, 1.0)]}
    assert ends_by_name(outline_basin(str(swept), 1).solutions) == {TRANSIENT: [(END, 1.0)]}
    assert ends_by_name(outline_basin(str(swept), 0).solutions) == {}


def test_a_preview_lists_the_end_even_if_no_cell_has_reached_it():
    oscillator = {name: getattr(OSCILLATOR, name) for name in ("damping", "eccentricity", "half_backlash")}
    grid = {"time": {"cells": 12}, "velocity": {"cells": 12}}
    shown = preview_basin(PreviewRequest(oscillator=oscillator, grid=grid, iterations=127))
    assert ends_by_name(shown.attractors) == {TRANSIENT: [(END, 1.0)]}
    assert shown.shares[[each.name for each in shown.attractors].index(END)] == 0.0
    assert PreviewView.from_preview(shown, 127).solutions[-1].ends


def test_a_store_of_before_has_no_ends_and_is_read_as_ever(alone, tmp_path):
    store = shutil.copytree(alone, tmp_path / "store")
    group = zarr.open_group(store, use_consolidated=False)
    del group[ENDS.path]
    zarr.consolidate_metadata(store)
    assert told_ends(summarise(str(store))) == {}
    assert rattle.check(store, dry_run=True).damages == ()
    basin = rattle.open(store)
    assert ends_by_name(basin.rattle.catalogue()) == {} and "ends_in" not in basin.rattle.to_table()
    BasinStore(str(store)).solutions.empty()


def test_a_lost_chunk_of_ends_is_damage(alone, tmp_path):
    store = shutil.copytree(alone, tmp_path / "store")
    (chunk,) = (path for path in (store / ENDS.path).rglob("*") if path.is_file() and path.name != "zarr.json")
    chunk.unlink()
    assert [damage.array for damage in rattle.check(store, dry_run=True).damages] == [ENDS.path]


@pytest.mark.parametrize(
    ("ends", "told"),
    [((), ""), (((1, 1.0),), "ends in P(4,4,2)"), (((1, 0.765625),), "ends in P(4,4,2) (77 %); 23 % had not ended"),
     (((0, 0.25), (1, 0.75)), "ends in P(4,4,2) (75 %), permanent contact (25 %)")],
)  # fmt: skip
def test_ends_in_words_have_shares_unless_all_is_one(ends, told):
    assert ends_in_words(ends, ["permanent contact", "P(4,4,2)"]) == told
