"""Independent scramblings give a share the error that it has."""

import numpy as np
import pytest
import xarray as xr
from scipy.stats import binom, t

from rattle_kernels import CellGrid
from tests.worker.basins.test_pipeline import content, run
from worker.errors import InvalidJob
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import SweptParameter
from worker.stores.solution_table import share_error

UNIT = CellGrid(0.0, 1.0, 1, 0.0, 1.0, 1)
SEEDS, LEVEL = 400, 0.95
# Share of each set of departures, by integration.
SETS = {
    "disc": (lambda x, y: (x - 0.4) ** 2 + (y - 0.55) ** 2 < 0.09, 0.09 * np.pi),
    "below a curve": (lambda x, y: y < 0.5 + 0.3 * np.sin(2.0 * np.pi * x + 0.4), 0.5),
    "bands across": (lambda x, y: np.sin(9.0 * np.pi * (x + y)) > 0.0, None),
    "a small spot": (lambda x, y: (x - 0.31) ** 2 + (y - 0.77) ** 2 < 0.002, 0.002 * np.pi),
}


def share_of(inside, known):
    if known is not None:
        return known
    centres = (np.arange(4000) + 0.5) / 4000
    return inside(centres[:, None], centres).mean()


def counted(sample, inside):
    """Points of each set that lie inside, and outside."""
    hits = inside(*sample.departures(UNIT, 0, sample.points))
    number = np.arange(sample.points) % sample.scramblings
    inside_of = np.bincount(number[hits], minlength=sample.scramblings)
    return np.stack([inside_of, sample.points // sample.scramblings - inside_of], axis=1)


@pytest.mark.slow
@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("scramblings", [8, 16])
def test_the_interval_holds_the_true_share_as_often_as_it_says(name, scramblings):
    inside, known = SETS[name]
    true, factor = share_of(inside, known), t.ppf(0.5 + LEVEL / 2, scramblings - 1)
    held, far = 0, []
    for seed in range(SEEDS):
        sample = Sample(128 * scramblings, seed, scramblings)
        counts = counted(sample, inside)
        share, (error, _) = counts[:, 0].sum() / sample.points, share_error(counts, sample.points)
        held += abs(share - true) <= factor * error
        far.append((share - true) / error)
    # What a fair coin of that level throws once in ten thousand times less often or more often. The law of the sets is
    # only nearly normal, so the level itself may be off by 2 %.
    least, most = binom(SEEDS, LEVEL - 0.02).ppf(1e-4), binom(SEEDS, LEVEL + 0.02).ppf(1 - 1e-4)
    assert least <= held <= most
    # The error is neither too small nor, as Laplace's is, several times too large.
    spread = np.sqrt((scramblings - 1) / (scramblings - 3))
    assert 0.8 * spread < np.std(far) < 1.25 * spread


def test_independent_points_would_claim_larger_errors():
    """Why it is worth it: the same points, as if they were independent."""
    inside, _ = SETS["disc"]
    counts = counted(Sample(16384, 1, 16), inside)
    assert share_error(counts.sum(axis=0, keepdims=True), 16384)[0] > 2.0 * share_error(counts, 16384)[0]


def test_where_all_sets_agree_the_error_is_laplaces():
    counts = np.array([[0, 64, 32, 32], [0, 64, 32, 32], [0, 64, 31, 33]])
    laplace = share_error(counts.sum(axis=0, keepdims=True), 192)
    error = share_error(counts, 192)
    assert error[:2].tolist() == laplace[:2].tolist() and 0.0 < error[2] == pytest.approx(error[3])
    assert error[2] == pytest.approx(np.std([32, 32, 31], ddof=1) / 64 / np.sqrt(3))


def test_one_scrambling_is_the_sequence_and_the_request_of_before():
    plain, named = (
        BasinJob(sample=Sample(512, 3)),
        BasinJob.from_request({"sample": {"points": 512, "seed": 3, "scramblings": 1}}),
    )
    assert plain.request() == named.request() and plain.digest == named.digest
    assert plain.request()["sample"] == {"points": 512, "seed": 3}
    assert BasinJob(sample=Sample(512, 3, 4)).request()["sample"] == {"points": 512, "seed": 3, "scramblings": 4}


@pytest.mark.parametrize(("start", "stop"), [(0, 96), (17, 55), (3, 4), (64, 96)])
def test_a_part_of_the_points_is_that_part_of_all_sets(start, stop):
    sample = Sample(96, 5, 6)
    whole = np.array(sample.departures(UNIT, 0, 96))
    np.testing.assert_array_equal(sample.departures(UNIT, start, stop), whole[:, start:stop])


def test_sets_are_scrambled_each_by_itself():
    sample = Sample(96, 5, 6)
    x, y = sample.departures(UNIT, 0, 96)
    sets = [tuple(x[number::6]) + tuple(y[number::6]) for number in range(6)]
    assert len(set(sets)) == 6
    for number in range(6):
        # Each set is a Sobol net: 16 points have one in each sixteenth of either axis.
        assert sorted((16 * x[number::6]).astype(int)) == list(range(16)) == sorted((16 * y[number::6]).astype(int))


@pytest.mark.parametrize(
    ("scramblings", "told"),
    [(0, "1 to 1000"), (1001, "1 to 1000"), (7, "a multiple of the scramblings"), (512, "two points")],
)
def test_impossible_scramblings_are_refused(scramblings, told):
    with pytest.raises(InvalidJob, match=told):
        Sample(512, 0, scramblings)


@pytest.mark.slow
def test_a_sample_in_sets_writes_and_says_the_errors_of_its_sets(client, tmp_path):
    job = SweepJob(iterations=211, vary=(SweptParameter("damping", (0.6, 0.65)),), sample=Sample(4096, 1, 8))
    summary = run(job, tmp_path / "sample.zarr", client)
    with xr.open_zarr(tmp_path / "sample.zarr") as sample:
        assert "8 scramblings" in sample.share_error.attrs["long_name"]
        for number, basin in enumerate(summary.basins):
            solution = sample.solution.values[number]
            errors = {each.solution: each.standard_error for each in basin.shares}
            for motion, error in errors.items():
                shares = [(solution[each::8] == motion).mean() for each in range(8)]
                assert error == pytest.approx(np.std(shares, ddof=1) / np.sqrt(8)) or (
                    np.ptp(shares) == 0.0 and error > 0.0
                )
                assert error == sample.share_error.values[number, motion]
            assert (
                not set(range(sample.sizes["attractor"]))
                - set(errors)
                - set(np.flatnonzero(np.isnan(sample.share_error.values[number])))
            )
    again = run(job, tmp_path / "again.zarr", client)
    assert again.basins == summary.basins and content(tmp_path / "again.zarr") == content(tmp_path / "sample.zarr")
