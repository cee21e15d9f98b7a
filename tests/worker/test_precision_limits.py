"""What could only end undecided is refused with the bound; up to the bounds motions are decided, without a warning."""

import pytest

from rattle_kernels import CellGrid, Oscillator, OutsideDomain
from rattle_kernels.impact_map.adiabatic_invariant import capture_bound
from worker.errors import InvalidJob
from worker.jobs.basin_job import BasinJob
from worker.jobs.bifurcation_job import BifurcationJob
from worker.jobs.grazing_curve_job import GrazingCurveJob
from worker.jobs.orbits_job import OrbitsJob
from worker.jobs.trajectory_request import TrajectoryRequest
from worker.precision_limits import FOLLOWED, check_decidable


@pytest.mark.parametrize(
    ("oscillator", "told"),
    [
        ({"damping": 1e15}, "damping must be at most 2^40 = 1.09951e+12, not 1e+15"),
        ({"half_backlash": 1e-300}, "half_backlash must be at least 4 pi damping 2^-80 = 6.2"),
        ({"half_backlash": 1e9}, "^2)/damping = 436907, not 1e+09"),
        ({"damping": 1e10}, "^2)/damping = 2.62144e-05, not 0.6"),
    ],
)
def test_an_oscillator_beyond_double_precision_is_refused_with_the_bound(oscillator, told):
    jobs = BasinJob, OrbitsJob, GrazingCurveJob
    for job in jobs:
        with pytest.raises(OutsideDomain) as refused:
            job.from_request({"oscillator": oscillator})
        assert told in str(refused.value)
    with pytest.raises(OutsideDomain):
        TrajectoryRequest.model_validate({"oscillator": oscillator, "start": {"velocity": 1.0}}).follow()
    with pytest.raises(OutsideDomain):
        vary = {"parameter": "eccentricity", "values": [0.05, 0.1]}
        BifurcationJob.from_request({"oscillator": oscillator, "vary": vary})


def test_a_window_too_fast_to_be_decided_is_refused_with_the_speed():
    with pytest.raises(InvalidJob, match="speeds must be at most 189359, not 1e\\+06") as refused:
        BasinJob.from_request({"grid": {"velocity": {"stop": 1e6}}})
    assert refused.value.place == ("grid", "velocity", "stop")
    limit = 4 * 0.6 * 0.6 * (1499 + FOLLOWED)
    assert f"{limit:.6g}" == "189359"
    BasinJob.from_request({"grid": {"velocity": {"stop": 0.999 * limit}}})
    with pytest.raises(InvalidJob, match="speeds must be at most 3.15598e-07, not 7"):
        BasinJob.from_request({"oscillator": {"half_backlash": 1e-12}})


def test_speeds_of_analyses_have_a_bound_too():
    with pytest.raises(InvalidJob, match="does not resolve shorter flights"):
        OrbitsJob.from_request({"region": {"velocity": {"start": 0, "stop": 1e13}}})
    with pytest.raises(InvalidJob, match="speeds must be at most 2.19902, not 7"):
        GrazingCurveJob.from_request({"oscillator": {"half_backlash": 1e-12}})


@pytest.mark.parametrize("damping", [0.1, 0.6, 1e3, 1e6])
def test_below_the_bound_of_the_backlash_something_is_captured(damping):
    limit = 2.0**18 * min(1.0, (damping / 0.6) ** 2) / damping
    assert capture_bound(check_decidable(Oscillator(damping=damping, eccentricity=0.01, half_backlash=limit))) > 0.0
    with pytest.raises(OutsideDomain):
        check_decidable(Oscillator(damping=damping, half_backlash=1.001 * limit))


@pytest.mark.parametrize(
    ("oscillator", "velocity"),
    [
        (Oscillator(half_backlash=1e-12), 3e-7),
        (Oscillator(damping=4e5), 7.0),
        pytest.param(Oscillator(), 1.8e5, marks=pytest.mark.slow),
    ],
)
def test_up_to_the_bounds_motions_are_decided_without_a_warning(tmp_path, oscillator, velocity):
    """Warnings are errors in tests, in the threads that compute as well: one would fail the job."""
    from rattle.results.opening import open as open_result
    from rattle.verbs import compute

    grid = CellGrid(time_cells=4, velocity_cells=4, velocity_stop=velocity)
    job = BasinJob(oscillator=oscillator, grid=grid)
    compute(job, store=tmp_path / "basin.zarr", workers=1, progress=False)
    found = open_result(tmp_path / "basin.zarr")
    assert (found.solution.values >= 0).all()
    undecided = found.share.values[found.name.values == "undecided"]
    assert not undecided.sum() > 0.0
