"""The loudness of motions is that of closed formulas, of balances of energy and of time histories."""

import math

import numpy as np
import pytest

from rattle_kernels import (
    Attractor,
    AttractorKind,
    Direction,
    Harmonic,
    Loudness,
    Oscillator,
    expected_loudness,
    find_attractors,
    loudness,
    single_contact_orbits,
    time_history,
)
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.model.domain import check_oscillator
from worker.stores.solution_table import share_error

# Departures that end on P(1,1,0), and where chaos or what has come in its place rattles.
SEEDS = [0.89829, 0.553], [3.76991, 4.703]
# Errors allowed: one test in a million fails by chance, and none twice, as everything is deterministic.
ERRORS = 5.0


def motions_of(oscillator):
    return {each.name: each for each in find_attractors(oscillator, *SEEDS)}


@pytest.fixture(scope="module")
def chaos():
    return motions_of(Oscillator())["chaotic"]


def turn_of(oscillator, attractor, periods=None):
    """One turn of a motion as a time history, from its first departure."""
    return time_history(
        oscillator, attractor.time[0], oscillator.half_backlash, -attractor.velocity[0],
        **({"departures": attractor.upper_contacts} if periods is None else {"periods": periods}),
        samples_per_period=4000,
    )  # fmt: skip


def arrivals(oscillator, history):
    """Speeds of arrival at the walls."""
    contacts = history.contacts
    inwards = contacts.direction != Direction.OUT
    return contacts.speed[inwards]


def touching(history):
    """How long teeth touch: from each entry to the next exit, or to the end. A turn begins with an exit."""
    contacts = history.contacts
    within = contacts.direction != Direction.IMPACT
    times, directions = contacts.time[within], contacts.direction[within]
    first = 1 if directions.size and directions[0] == Direction.OUT else 0
    enters, leaves = times[first::2], times[first + 1 :: 2]
    assert (directions[first::2] == Direction.IN).all() and (directions[first + 1 :: 2] == Direction.OUT).all()
    if enters.size > leaves.size:
        leaves = np.append(leaves, history.time[-1])
    return float((leaves - enters).sum())


@pytest.mark.parametrize("m", [1, 2, 3])
def test_elastic_orbits_of_one_impact_have_the_speed_of_the_closed_formula(m):
    oscillator = Oscillator(0.1, 0.028, 1.5)
    orbit = single_contact_orbits(oscillator, m)[0]
    assert orbit.exists
    points = np.array([orbit.t]), np.array([orbit.v])
    heard = loudness(oscillator, Attractor(AttractorKind.PERIODIC, m, 1, 0, np.nan, np.nan, *points))
    speed = 2.0 * math.pi * 0.1 * m
    # The orbit is known to rounding, and one application keeps that.
    np.testing.assert_allclose(heard[:3], [1.0 / m, speed, speed**2 / (2.0 * m)], rtol=1e-12)
    assert heard[3:] == (0.0,) * 4, "nor is any time spent in contact"


@pytest.mark.parametrize("restitution", [0.97, 0.95, 0.9])
def test_an_impact_that_loses_energy_arrives_faster_than_it_leaves(restitution):
    oscillator = Oscillator(restitution=restitution)
    orbit = motions_of(oscillator)["P(1,1,0)"]
    arrives = 4.0 * math.pi * 0.6 / (1.0 + restitution)
    # Newton's method stops at a residual of 1e-11.
    np.testing.assert_allclose(orbit.velocity, restitution * arrives, rtol=1e-10)
    np.testing.assert_allclose(loudness(oscillator, orbit)[:3], [1.0, arrives, arrives**2 / 2.0], rtol=1e-10)


OTHERS = {
    "impacts that lose energy": Oscillator(restitution=0.97),
    "soft contacts": Oscillator(stiffness=1e3),
    "a window of the cascade": Oscillator(damping=0.527),
    "a second harmonic": Oscillator(damping=0.527, harmonics=(Harmonic(2, 0.002, 0.1),)),
    "contacts that lose energy": Oscillator(stiffness=1e3, contact_damping=0.01),
}


@pytest.mark.parametrize(
    "oscillator",
    [pytest.param(each, marks=pytest.mark.slow) if each.harmonics else each for each in OTHERS.values()],
    ids=OTHERS,
)
def test_time_histories_have_the_same_impacts(oscillator):
    compared = []
    for name, attractor in motions_of(oscillator).items():
        if attractor.kind != AttractorKind.PERIODIC:
            continue
        history = turn_of(oscillator, attractor)
        speeds = arrivals(oscillator, history)
        m, impacts, largest, power, contact, *_ = attractor.forcing_periods, *loudness(oscillator, attractor)
        assert speeds.size == attractor.upper_contacts + attractor.lower_contacts == round(impacts * m)
        np.testing.assert_allclose([largest, power], [speeds.max(), (speeds**2).sum() / (2 * m)], rtol=1e-8)
        assert contact == pytest.approx(touching(history) / m, rel=1e-8, abs=0.0)
        compared.append(name)
    assert compared


@pytest.mark.parametrize(
    ("oscillator", "walls"),
    [
        (Oscillator(0.1, 0.1, 0.03, restitution=0.5), {1}),
        (Oscillator(0.1, 0.4, 0.1, restitution=0.5), {1}),
        (Oscillator(0.1, 0.4, 0.03, restitution=0.5), {-1, 1}),
    ],
)
def test_time_histories_rest_as_long(oscillator, walls):
    """But for bounces below 1e-9 of the scale of speeds, which count as rest: they are a geometric series."""
    orbit = next(each for each in find_attractors(oscillator, [0.3], [1.0]) if each.name.endswith("*"))
    history = turn_of(oscillator, orbit, orbit.forcing_periods)
    begins = history.contacts.direction == Direction.IN
    assert set(history.contacts.wall[begins]) == walls
    d, e, angle = oscillator.damping, oscillator.eccentricity, 2.0 * math.pi * history.contacts.time[begins]
    pressed = np.abs(4.0 * math.pi * d - 2.0 * math.pi * e * (2.0 * math.pi * np.cos(angle) + d * np.sin(angle)))
    slowest = 1e-9 * lane_tables(check_oscillator(oscillator)).largest_grazing_speed
    bounces = (2.0 * slowest / pressed / (1.0 - oscillator.restitution)).sum()
    longer = loudness(oscillator, orbit).time_in_contact * orbit.forcing_periods - touching(history)
    # p hardly changes while they last. Rounding, and bounces that the history does not follow, are 1e-12.
    assert -1e-12 < longer < 1.001 * bounces + 1e-12 and touching(history) > 0.0


def test_what_is_lost_in_impacts_is_what_the_forcing_has_done():
    oscillator = Oscillator(restitution=0.97)
    orbit = motions_of(oscillator)["P(2,2,1)"]
    history = turn_of(oscillator, orbit)
    delta, angle = oscillator.damping, 2.0 * math.pi * history.time
    first, second = -2.0 * math.pi * np.sin(angle), -((2.0 * math.pi) ** 2) * np.cos(angle)
    drive = 4.0 * math.pi * delta + oscillator.eccentricity * (second + delta * first)
    done = np.trapezoid((drive - delta * history.velocity) * history.velocity, history.time)
    lost = (1.0 - oscillator.restitution**2) * loudness(oscillator, orbit).impact_power * orbit.forcing_periods
    # The trapezoidal rule errs by h^2/12 times a second derivative of some (2 pi)^2 times 30, over two periods.
    assert done == pytest.approx(lost, abs=2.0 * 1200.0 / 12.0 / 4000.0**2 * 3.0)
    assert lost > 1.0


def test_permanent_contact_is_silent_and_what_is_undecided_is_not_known():
    silent, unknown = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), (np.nan,) * 7
    for kind, expected in ((AttractorKind.PERMANENT_CONTACT, silent), (AttractorKind.UNDECIDED, unknown)):
        heard = loudness(Oscillator(), Attractor(kind, 0, 0, 0, np.nan, np.nan, np.empty(0), np.empty(0)))
        np.testing.assert_array_equal(heard, expected)


def test_a_long_time_history_of_chaos_is_as_loud_within_the_errors(chaos):
    oscillator, periods, blocks = Oscillator(), 8000, 40
    history = time_history(
        oscillator, chaos.time[0], 0.6, -chaos.velocity[0], periods=periods, samples_per_period=1
    )  # fmt: skip
    contacts, heard = history.contacts, loudness(oscillator, chaos)
    block = ((contacts.time - history.time[0]) * blocks / periods).astype(int).clip(0, blocks - 1)
    counted = np.bincount(block) * blocks / periods, np.bincount(block, contacts.speed**2 / 2.0) * blocks / periods
    told = (heard.impacts_per_period, heard.impacts_per_period_error), (heard.impact_power, heard.impact_power_error)
    for each, (mean, error) in zip(counted, told, strict=True):
        assert 0.0 < error < 0.002 * mean
        other = each.std(ddof=1) / math.sqrt(blocks)
        assert abs(each.mean() - mean) < ERRORS * math.hypot(error, other)
    # No speed of either stretch is far beyond those of the other.
    assert contacts.speed.max() == pytest.approx(heard.largest_impact_speed, rel=0.01)


def test_errors_of_chaos_are_those_of_its_scatter(chaos):
    """Parts of the catalogue that share no trajectory give means that scatter as their errors say."""
    parts = [chaos._replace(time=chaos.time[i::16], velocity=chaos.velocity[i::16]) for i in range(16)]
    heard = np.array([loudness(Oscillator(), part) for part in parts])
    for mean, error in ((0, 4), (2, 5)):
        ratio = heard[:, mean].std(ddof=1) / np.sqrt((heard[:, error] ** 2).mean())
        assert 0.4 < ratio < 1.75  # chi^2 of 15 degrees: beyond these in one of five thousand


def test_the_same_motion_is_heard_alike(chaos):
    assert loudness(Oscillator(), chaos) == loudness(Oscillator(), chaos)


LOUD, SILENT = Loudness(1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0), Loudness(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def test_expectations_are_shares_times_loudness_and_undecided_shares_are_named():
    unknown, chaotic = Loudness(*(math.nan,) * 7), Loudness(1.6, 4.8, 10.0, 0.1, 0.01, 0.2, 0.02)
    told = expected_loudness([0.5, 0.25, math.nan, 0.2, 0.05], [SILENT, LOUD, LOUD, chaotic, unknown])
    np.testing.assert_allclose(told, [0.57, 1.21, 2.25, 0.52, 0.002, 0.0, 0.04, 0.004, 0.05])
    assert np.isnan(expected_loudness([math.nan], [SILENT])).all()


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_expectations_of_a_sample_have_the_errors_of_its_shares(share):
    told = expected_loudness([1.0 - share, share], [SILENT, LOUD], points=100)
    counts = np.array([[100 - round(100 * share), round(100 * share)]])
    assert told.impact_power_error == pytest.approx(share_error(counts, 100)[1], rel=1e-12)
    assert expected_loudness([1.0 - share, share], [SILENT, LOUD]).impact_power_error == 0.0


def test_motions_that_are_alike_leave_no_error():
    for share in np.linspace(0.0, 1.0, 101):
        told = expected_loudness([1.0 - share, share], [SILENT, SILENT], points=7)
        # The root of what rounding leaves of 1 - 1.
        assert told.time_in_contact == pytest.approx(1.0) and 0.0 <= told.time_in_contact_error < 3e-8


def test_expectations_of_scrambled_sets_have_the_error_of_their_scatter():
    told = expected_loudness([0.7, 0.3], [SILENT, LOUD], 100, [[0.68, 0.32], [0.72, 0.28]])
    assert told.impact_power_error == pytest.approx(np.std([0.32, 0.28], ddof=1) / math.sqrt(2.0), rel=1e-12)
    agree = expected_loudness([0.7, 0.3], [SILENT, LOUD], 100, [[0.7, 0.3], [0.7, 0.3]])
    assert agree == expected_loudness([0.7, 0.3], [SILENT, LOUD], 100)
