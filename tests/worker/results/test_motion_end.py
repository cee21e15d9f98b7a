"""What a followed motion does in the end, against its own further history and against the impact map."""

import numpy as np
import pytest

from rattle_kernels import AttractorKind, Direction, Oscillator, find_attractors, next_impacts, time_history
from worker.errors import InvalidJob
from worker.jobs.trajectory_request import TrajectoryRequest
from worker.results.motion_end import FOLLOWED_PERIODS, end_of, motion_end

PLACES = 100
OSCILLATORS = [
    Oscillator(0.6, 0.1, 0.6),
    Oscillator(0.321, 0.1, 0.6),
    Oscillator(0.6, 0.1, 0.6, restitution=0.8),
    Oscillator(0.6, 0.1, 0.6, stiffness=1e4),
]


def follow(oscillator, t, v, periods, samples=1):
    return time_history(
        oscillator, t, oscillator.half_backlash, -v, periods=periods, samples_per_period=samples, most_contacts=20_000
    )


@pytest.mark.parametrize(
    "oscillator",
    [pytest.param(OSCILLATORS[0], marks=pytest.mark.slow), *OSCILLATORS[1:]],
    ids=["paper", "weakly damped", "losses", "stiff"],
)
def test_what_is_said_of_a_motion_is_what_it_does(oscillator):
    random = np.random.default_rng(41)
    kinds = set()
    for t, v in zip(random.uniform(0.0, 1.0, PLACES).tolist(), random.uniform(0.2, 7.0, PLACES).tolist(), strict=True):
        history = follow(oscillator, t, v, FOLLOWED_PERIODS)
        end = motion_end(oscillator, history, (t, v))
        if end.settled is None:
            # It rattles at the end of the history: it strikes with speed, and does not come back to where it was.
            assert history.contacts.time[-1] > t + FOLLOWED_PERIODS - 2.0 and np.isinf(history.permanent_from)
            assert end.periods == pytest.approx(FOLLOWED_PERIODS)
            kinds.add("rattling")
        elif end.settled.kind == AttractorKind.PERMANENT_CONTACT:
            # A longer history stays at the wall from then on.
            longer = follow(oscillator, t, v, 2.0 * FOLLOWED_PERIODS, 3)
            late = longer.displacement[longer.time > t + end.periods + 20.0]
            assert np.abs(np.abs(late) - oscillator.half_backlash).max() < 0.01 * oscillator.half_backlash
            kinds.add("quiet")
        else:
            # The impact map, applied once around, leads from its last departure to the same place, periods later.
            last = history.departures[-1]
            loss = oscillator.restitution if np.isinf(oscillator.stiffness) else 1.0
            speed = history.contacts.speed[last] * loss
            phase = history.contacts.time[last] % 1.0
            around = next_impacts(oscillator, [phase], [speed], end.settled.upper_contacts)
            away = around.t[0] - phase
            assert abs(away - round(away)) < 2e-3 and abs(around.v[0] - speed) < 1e-2
            assert end.periods < FOLLOWED_PERIODS
            # From when it has settled on, every departure is within 0.001 of the orbit, as is said of it.
            departures = history.contacts.time[history.departures], history.contacts.speed[history.departures] * loss
            then = departures[0] >= t + end.periods - 1e-12
            away = [
                one[then, None] - other
                for one, other in zip(departures, (end.settled.time, end.settled.velocity), strict=True)
            ]
            away[0] -= np.rint(away[0])
            assert np.abs(away).max(axis=0).min(axis=1).max() < 1e-3
            kinds.add("periodic")
    if oscillator == OSCILLATORS[0]:
        assert kinds == {"rattling", "quiet", "periodic"}


def test_a_loose_gear_settles_where_its_rests_repeat():
    oscillator = Oscillator(0.6, 0.22, 0.6, restitution=0.7)
    history = follow(oscillator, 0.5, 2.0, 60)
    end = motion_end(oscillator, history, (0.5, 2.0))
    assert end.settled is not None and end.settled.name == "P(1,1,0)*" and end.first is None
    # Nothing is left of what was before the first rest, so all of its releases are those of the orbit.
    first = history.contacts.time[history.contacts.direction == Direction.OUT][0]
    assert end.periods == pytest.approx(first - 0.5, abs=1e-9)


def test_a_loose_gear_of_finite_stiffness_settles_on_an_orbit_without_a_rest():
    oscillator = Oscillator(0.6, 0.22, 0.6, 1e3, contact_damping=0.2)
    history = follow(oscillator, 0.5, 2.0, 200)
    end = motion_end(oscillator, history, (0.5, 2.0))
    assert end.settled is not None and not end.settled.name.endswith("*")
    (_, *found) = find_attractors(oscillator, [0.5], [2.0])
    assert [end.settled.name] == [each.name for each in found]


def test_a_motion_from_a_saddle_leaves_it():
    """The unstable P(2,2,1) of Fig. 7 (bottom), in four digits."""
    oscillator = Oscillator(0.6, 0.1, 0.6)
    end = motion_end(oscillator, follow(oscillator, 0.7218, 4.4115, FOLLOWED_PERIODS), (0.7218, 4.4115))
    assert end.first is not None and end.first.name == "P(2,2,1)"
    assert 6.0 <= end.first.periods < 40.0
    assert end.settled is None or end.settled.name != "P(2,2,1)"


def test_the_end_is_told_of_departures_only():
    request = TrajectoryRequest(start={"time": 0.0, "displacement": 0.1, "velocity": 1.0})
    with pytest.raises(InvalidJob, match="departures from"):
        end_of(request, 100)
