"""The loudness of a store's motions and basins is the same in every view, and is what its catalogue says."""

import numpy as np
import pandas as pd
import pytest

from rattle_kernels import AttractorKind, CellGrid, Oscillator, loudness
from tests.worker.basins.made_up import QUIET, RATTLE, motion
from tests.worker.basins.test_pipeline import run
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import SweptParameter
from worker.results.measures import measure_loudness
from worker.results.opening import attractors_of, basin_of, open_basin
from worker.results.shares import shares_figure
from worker.results.summary import summarise
from worker.results.tables import table_of
from worker.results.viewer import outline_basin
from worker.stores.basin_store import BasinStore
from worker.stores.solution_table import SolutionTable, motion_of

MEASURES = ["impacts_per_period", "largest_impact_speed", "impact_power", "time_in_contact"]
DAMPINGS = (0.575, 0.6, 0.7)
GRID = CellGrid(time_cells=48, velocity_cells=40)
JOB = SweepJob(grid=GRID, vary=(SweptParameter("damping", DAMPINGS),))


@pytest.fixture(scope="module")
def location(client, tmp_path_factory):
    location = tmp_path_factory.mktemp("loudness") / "sweep.zarr"
    run(JOB, location, client)
    return str(location)


@pytest.fixture(scope="module")
def sweep(location):
    with open_basin(location) as dataset:
        yield dataset.load()


def test_motions_are_as_loud_as_their_catalogue_says_and_basins_as_their_shares(sweep):
    heard = measure_loudness(sweep)
    assert heard.impact_power.dims == ("damping", "attractor") and heard.expected_impact_power.dims == ("damping",)
    for number, damping in enumerate(DAMPINGS):
        basin, here = basin_of(sweep, damping=damping), heard.isel(damping=number)
        shares = basin.share.values
        alone = [loudness(JOB.oscillator_of(number), each) for each in attractors_of(basin)]
        for measure in MEASURES:
            own = np.array([getattr(each, measure) for each in alone])
            np.testing.assert_array_equal(here[measure], own)
            there = np.isfinite(shares)
            assert float(here[f"expected_{measure}"]) == pytest.approx(shares[there] @ own[there], rel=1e-14)
        assert here.undecided_share == 0.0
        # Exactly as a single basin has it, along a dimension of its own.
        single = measure_loudness(basin)
        assert single.expected_impact_power.dims == ("window",)
        np.testing.assert_array_equal(single.expected_impact_power, [here.expected_impact_power])


def test_summaries_outlines_and_charts_have_the_same_expectations(location, sweep):
    heard = measure_loudness(sweep)
    result = summarise(location).model_dump(mode="json")
    axes = shares_figure(location).axes
    assert [each.get_ylabel() for each in axes] == ["share", "impacts\na period", "largest\nspeed", "power"]
    for measure, place in zip(MEASURES[:3], axes[1:], strict=True):
        expected = heard[f"expected_{measure}"].values
        assert [basin["expected"][measure] for basin in result["basins"]] == pytest.approx(expected, rel=1e-14)
        np.testing.assert_allclose(place.get_lines()[0].get_ydata(), expected, rtol=1e-14)
        for panel in range(len(DAMPINGS)):
            outline = outline_basin(location, panel)
            assert getattr(outline.expected, measure) == pytest.approx(expected[panel], rel=1e-14)
            own = [getattr(each, measure) for each in outline.loudness]
            np.testing.assert_array_equal(own, heard[measure][panel])
    quiet = result["solutions"][0]
    assert [quiet[measure] for measure in MEASURES] == [0.0, 0.0, 0.0, 1.0]


def test_tables_of_motions_and_basins_have_it_and_others_do_not(sweep):
    table = table_of(sweep)
    assert {"share", *MEASURES, "impact_power_error"} <= set(table.columns) and table.impact_power.notna().all()
    basins = table_of(sweep, "damping")
    weighted = (table.share * table.impact_power).groupby(table.damping).sum()
    assert basins.expected_impact_power.tolist() == pytest.approx(weighted.tolist(), rel=1e-14)
    basin = basin_of(sweep, damping=0.6)
    assert "impact_power" in table_of(basin).columns
    assert isinstance(table_of(basin, "window"), pd.DataFrame) and len(table_of(basin, "window")) == 1
    assert "impact_power" not in table_of(sweep, "time").columns


def test_expectations_of_samples_have_errors_of_their_shares(client, tmp_path):
    points = 256
    run(BasinJob(grid=GRID, sample=Sample(points=points, seed=1)), tmp_path / "sample.zarr", client)
    with open_basin(tmp_path / "sample.zarr") as dataset:
        heard = measure_loudness(dataset)
        quiet = float(dataset.share_error.values[0])
    # All that rattles has a power between these, so the error lies between theirs, were all of it one motion.
    powers = heard.impact_power.values[1:]
    error = float(heard.expected_impact_power_error[0])
    assert 0.9 * powers.min() * quiet < error < 1.1 * powers.max() * quiet + powers.std()
    assert heard.expected_largest_impact_speed_error[0] > 0.0


def test_expectations_of_scrambled_sets_have_the_error_of_their_scatter(client, tmp_path):
    location, sets = tmp_path / "sets.zarr", 8
    run(BasinJob(grid=GRID, sample=Sample(512, 1, sets)), location, client)
    with open_basin(location) as dataset:
        heard = measure_loudness(dataset).load()
        solution = dataset.solution.values
    told = summarise(str(location)).basins[0].expected
    for measure in MEASURES:
        own = heard[measure].values
        expected = [own[solution[number::sets]].mean() for number in range(sets)]
        scatter = np.std(expected, ddof=1) / np.sqrt(sets)
        # Chaos has an error of its own, here some hundredth of the scatter's.
        assert float(heard[f"expected_{measure}_error"][0]) == pytest.approx(scatter, rel=0.01)
        assert getattr(told, f"{measure}_error") == pytest.approx(
            float(heard[f"expected_{measure}_error"][0]), rel=1e-14
        )


def test_undecided_cells_are_named_and_count_as_silent(tmp_path):
    store = BasinStore.create_or_resume(
        str(tmp_path / "new.zarr"), BasinJob(grid=CellGrid(time_cells=16, velocity_cells=16))
    )
    chaos = motion(AttractorKind.CHAOTIC, t=[0.553], v=[4.703])
    listed = QUIET, RATTLE, chaos, motion(AttractorKind.UNDECIDED)
    table = SolutionTable.empty(store.job)
    numbers = [table.append(motion_of(attractor)) for attractor in listed]
    table.enter(0, numbers, listed, np.array([0.5, 0.25, 0.125, 0.125]))
    store.solutions.make_room(table, 1)
    store.solutions.write(table)
    assert outline_basin(store.location, 0).expected is None  # points are not there yet
    store.solutions.write_points(0, numbers, listed)
    expected = outline_basin(store.location, 0).expected
    known = [loudness(Oscillator(), each).impact_power for each in (RATTLE, chaos)]
    assert expected.undecided_share == 0.125
    assert expected.impact_power == pytest.approx(0.25 * known[0] + 0.125 * known[1], rel=1e-14)
    with open_basin(store.location) as dataset:
        assert measure_loudness(dataset).undecided_share == [0.125]
    told = summarise(store.location).solutions[3]
    assert told.kind == "undecided" and told.impact_power is None
