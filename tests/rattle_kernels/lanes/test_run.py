"""Short runs and long ones: the same bytes as P applied one by one, whatever flies beside a point."""

import numpy as np
import pytest

from rattle_kernels import Oscillator, Outcome, next_impacts
from rattle_kernels.lanes import short_run
from rattle_kernels.lanes.run import run_lanes

MODELS = [Oscillator(), Oscillator(stiffness=1000.0)]
IDS = ["impacting", "piecewise linear"]


def _departures(size):
    chance = np.random.default_rng(3)
    t, v = 5.0 * chance.random(size) - 2.0, 7.0 * chance.random(size)
    v[::9] *= 1e-6
    return t, v


def _one_by_one(oscillator, t, v, applications):
    lower = np.zeros(t.size, np.int64)
    for _ in range(applications):
        t, v, met, _ = next_impacts(oscillator, t, v)
        lower += met
    return t, v, lower


@pytest.mark.parametrize("oscillator", MODELS, ids=IDS)
@pytest.mark.parametrize("applications", [2, short_run.LONGEST_SHORT_RUN, short_run.LONGEST_SHORT_RUN + 1, 40])
def test_many_applications_are_one_application_many_times(oscillator, applications):
    t, v = _departures(500)
    at_once = next_impacts(oscillator, t, v, applications)
    for field, expected in zip(at_once[:3], _one_by_one(oscillator, t, v, applications), strict=True):
        assert field.tobytes() == expected.tobytes()


@pytest.mark.parametrize("oscillator", MODELS, ids=IDS)
def test_a_batch_of_any_size_gives_each_point_its_own_end(oscillator, monkeypatch):
    t, v = _departures(200)
    whole = next_impacts(oscillator, t, v, 3)
    monkeypatch.setattr(short_run, "_APPLICATIONS_A_LEG", 7 * 3)
    for size in (1, 63, 64, 65):
        part = next_impacts(oscillator, t[-size:], v[-size:], 3)
        for field, expected in zip(part, whole, strict=True):
            assert field.tobytes() == expected[-size:].tobytes()


@pytest.mark.parametrize("oscillator", [*MODELS, Oscillator(stiffness=100.0)], ids=[*IDS, "soft"])
def test_lanes_without_a_point_never_take_the_careful_path(oscillator):
    alone = run_lanes(oscillator, np.array([0.55]), np.array([4.67]), 5000, shortcuts=False)[1]
    full = run_lanes(oscillator, np.full(64, 0.55), np.full(64, 4.67), 5000, shortcuts=False)[1]
    assert full == tuple(64 * count for count in alone)


def test_points_that_do_not_depart_are_outside_the_section_and_hold_nobody_up():
    t, v = np.array([0.2, np.nan, 0.2, np.inf, 0.2, 0.2]), np.array([1.0, 1.0, 0.0, 1.0, -1.0, np.inf])
    landed, _ = run_lanes(Oscillator(), t, v, 2, shortcuts=False)
    assert landed.outcome.tolist() == [Outcome.RETURNED] + 5 * [Outcome.OUTSIDE_SECTION]
    assert np.isfinite(landed.v).tolist() == [True] + 5 * [False]


def test_a_captured_point_stays_where_it_was_captured_however_long_the_run():
    t, v = _departures(2000)
    ends = [run_lanes(Oscillator(), t, v, applications, shortcuts=True)[0] for applications in (1, 2, 4, 15, 60)]
    for earlier, later in zip(ends[:-1], ends[1:], strict=True):
        captured = earlier.outcome == Outcome.PERMANENT_CONTACT
        assert captured.any()
        assert later.outcome[captured].tolist() == earlier.outcome[captured].tolist()
        assert later.t[captured].tobytes() == earlier.t[captured].tobytes()
        assert later.v[captured].tobytes() == earlier.v[captured].tobytes()


@pytest.mark.parametrize("applications", [3, 40])
def test_applications_are_counted(applications):
    t, v = _departures(300)
    _, run = run_lanes(Oscillator(), t, v, applications, shortcuts=False)
    assert run.applications == 300 * applications


def test_arrays_of_any_kind_are_flown_by_the_kernel_that_is_there():
    t, v = _departures(200)
    whole = next_impacts(Oscillator(), t, v, 3)
    compiled = len(short_run._fly_leg.signatures)
    kept = t.copy(), v.copy()
    for each in kept:
        each.flags.writeable = False
    apart = np.column_stack([t, v])
    for time, speed in (kept, apart.T, (t.tolist(), v.tolist())):
        again = next_impacts(Oscillator(), time, speed, 3)
        assert all(field.tobytes() == expected.tobytes() for field, expected in zip(again, whole, strict=True))
    assert len(short_run._fly_leg.signatures) == compiled
    assert (t == kept[0]).all() and (v == kept[1]).all()
