"""Charts: what is drawn is there, once, and true of machines beside it; requests that cannot be served are refused."""

import threading

import numpy as np
import pytest

import rattle
from rattle_chart.analysis import CHART, machines_of_row
from rattle_chart.job import ChartJob
from rattle_kernels import (
    CodimensionTwo,
    Oscillator,
    SpecialKind,
    find_orbit,
    find_orbits,
    grazing_velocity,
    next_impacts,
    single_contact_orbits,
)
from tests.store_content import content
from worker.cluster.driver import Driver
from worker.errors import InvalidJob, JobCancelled
from worker.jobs.region import Region
from worker.run import run_job

WINDOW = {
    "first": {"parameter": "damping", "start": 0.75, "stop": 0.78},
    "second": {"parameter": "eccentricity", "start": 0.094, "stop": 0.0995},
}
JOB = ChartJob(**WINDOW, lines=2, pixels=4, departures=16)
KINDS = tuple(SpecialKind)


def run(client, location, report=lambda _: None, cancel=None):
    run_job(JOB, str(location), Driver(client), report=report, cancel=cancel or threading.Event())


@pytest.fixture(scope="module")
def store(client, tmp_path_factory):
    location = tmp_path_factory.mktemp("chart") / "chart.zarr"
    run(client, location)
    return location


@pytest.fixture(scope="module")
def chart(store):
    return rattle.open(store)


def curves_of(chart):
    """Kind, n+ and n-, and the points of each curve."""
    stops = np.cumsum(chart.curve_size.values)
    for stop, size, kind, upper, lower in zip(
        stops, chart.curve_size.values, chart.curve_kind.values, chart.curve_upper_contacts.values,
        chart.curve_lower_contacts.values, strict=True,
    ):  # fmt: skip
        own = slice(stop - size, stop)
        points = np.column_stack([chart.curve_damping.values[own], chart.curve_eccentricity.values[own]])
        yield KINDS[kind - 1], (int(upper), int(lower)), points


def test_it_has_both_points_that_organise_the_window(chart):
    kinds = [tuple(CodimensionTwo)[kind - 1] for kind in chart.point_kind.values]
    found = dict(zip(kinds, zip(chart.point_damping.values, chart.point_eccentricity.values, strict=True), strict=True))
    assert found.keys() == {CodimensionTwo.NEUTRAL_GRAZE, CodimensionTwo.SADDLE_NODE_GRAZE}
    assert found[CodimensionTwo.NEUTRAL_GRAZE] == pytest.approx((0.7601647632, 0.0957060530), abs=1e-10)
    assert found[CodimensionTwo.SADDLE_NODE_GRAZE] == pytest.approx((0.770147130934, 0.097890812717), abs=1e-11)


def test_each_curve_is_there_once(chart):
    listed = sorted((str(kind), orbit) for kind, orbit, _ in curves_of(chart))
    assert listed == [
        ("grazing", (1, 0)), ("grazing", (2, 1)), ("period doubling", (1, 1)), ("saddle-node", (1, 0)),
        ("saddle-node", (1, 1)),
    ]  # fmt: skip
    # Beside a graze the derivatives of saddle-nodes and doublings are known to rounding over the speed at -beta.
    assert (chart.curve_residual.values < 1e-9).all()


def test_curves_stay_in_the_window_and_end_in_points_where_they_lead_to_one(chart):
    points = {
        tuple(CodimensionTwo)[kind - 1]: place
        for kind, *place in zip(
            chart.point_kind.values, chart.point_damping.values, chart.point_eccentricity.values, strict=True
        )
    }
    led = 0
    for (_, _, places), ends in zip(curves_of(chart), chart.curve_end.values, strict=True):
        assert ((places >= [0.75, 0.094]) & (places <= [0.78 + 1e-15, 0.0995 + 1e-15])).all()
        for place, end in zip(places[[0, -1]], ends, strict=True):
            for kind, there in points.items():
                if str(end).startswith(f"the {kind} "):
                    led += 1
                    assert place == pytest.approx(there, abs=1e-15)
    assert led == 4, "of the saddle-nodes of P(1,1,0) and of P(1,1,1), of doublings, and of the graze of P(2,2,1)"


def test_a_graze_persists_between_its_two_points_alone(chart):
    """N_12 changes its sign at the neutral graze, det(I - N) where the saddle-node meets the graze."""
    stops = np.cumsum(chart.curve_size.values)
    kinds = [(kind, orbit) for kind, orbit, _ in curves_of(chart)]
    place = kinds.index((SpecialKind.GRAZING, (1, 0)))
    own = slice(stops[place] - chart.curve_size.values[place], stops[place])
    low, high = sorted(chart.point_damping.values)
    damping, response = chart.curve_damping.values[own], chart.curve_response.values[own]
    between = (damping > low) & (damping < high)
    assert between.any() and not between.all() and ((response > 0.0) == between).all()
    assert np.isnan(chart.curve_response.values[: stops[0]]).all() == (kinds[0][0] != SpecialKind.GRAZING)


def test_machines_beside_each_curve_do_what_it_says(chart):
    """Three points of each, and a little to both sides in the damping."""
    for kind, (upper, lower), points in curves_of(chart):
        if (upper, lower) != (1, 0):
            continue
        for damping, eccentricity in points[[len(points) // 4, len(points) // 2, 3 * len(points) // 4]]:
            sides = [Oscillator(damping + side * 1e-6, eccentricity) for side in (-1, 1)]
            pairs = [single_contact_orbits(side) for side in sides]
            if kind == SpecialKind.SADDLE_NODE:
                assert {len(pair) for pair in pairs} == {0, 2}, "two orbits are born"
            else:
                margins = [
                    [each.v - float(grazing_velocity(side, each.t)) for each in pair]
                    for side, pair in zip(sides, pairs, strict=True)
                ]  # fmt: skip
                assert any(below * above < 0.0 for below, above in zip(*margins, strict=True)), "one begins to hit"


def test_orbits_of_a_saddle_node_are_met_on_one_side_alone(chart):
    """By Newton's method from 189 departures around three points of each, a little to both sides in the damping."""
    stops = np.cumsum(chart.curve_size.values)
    seen = 0
    for stop, (kind, (upper, lower), points) in zip(stops, curves_of(chart), strict=True):
        if kind != SpecialKind.SADDLE_NODE:
            continue
        for part in (len(points) // 4, len(points) // 2, 3 * len(points) // 4):
            place = stop - len(points) + part
            t, v = chart.curve_time.values[place], chart.curve_velocity.values[place]
            departures = np.stack(np.meshgrid(t + np.linspace(-2e-3, 2e-3, 21), v + np.linspace(-1e-2, 1e-2, 9)))
            sides = []
            for side in (-1e-6, 1e-6):
                oscillator = Oscillator(points[part, 0] + side, points[part, 1])
                found = [find_orbit(oscillator, *each, upper) for each in departures.reshape(2, -1).T.tolist()]
                near = [
                    each.orbit for each in found if each is not None and np.abs(each.orbit.v - v).min() < 1e-2
                ]  # fmt: skip
                sides.append(any((each.upper_contacts, each.lower_contacts) == (upper, lower) for each in near))
            assert sides[0] != sides[1]
            seen += 1
    assert seen == 6


def index(oscillator, t, v, contacts, radius):
    """How often the displacement by so many applications of P turns along a circle around a departure.

    Orbits within count as signs of det(1 - DP), and no derivative is taken. Points are added where it turns fast.
    """
    angle = np.linspace(0.0, 2.0 * np.pi, 257)
    for _ in range(40):
        from_t, from_v = t + radius * np.cos(angle), v + 10.0 * radius * np.sin(angle)
        to = next_impacts(oscillator, from_t, from_v, contacts)
        moved = to.t - from_t
        turned = np.unwrap(np.arctan2(0.1 * (to.v - from_v), moved - np.rint(moved)))
        fast = np.flatnonzero(np.abs(np.diff(turned)) > 1.0)
        if not fast.size:
            return round((turned[-1] - turned[0]) / (2.0 * np.pi))
        angle = np.sort(np.append(angle, 0.5 * (angle[fast] + angle[fast + 1])))
    raise AssertionError("the displacement jumps")


def test_orbits_that_vanish_together_have_no_index_and_those_that_persist_have_one(chart):
    """At some points of every curve: the sum over the orbits on one side is that on the other."""
    stops = np.cumsum(chart.curve_size.values)
    seen = {}
    for stop, (kind, (upper, _), points) in zip(stops, curves_of(chart), strict=True):
        for part in np.linspace(0, len(points), 8)[1:-1].astype(int):
            place = stop - len(points) + part
            response = chart.curve_response.values[place]
            # Where a graze has little response the next orbits are near. Nearer still the phase, whose rounding has a
            # root of 1e-8, is not known well enough.
            if abs(response) < 1e-4:
                continue
            radius = np.fmin(1e-5, 10.0 * response**2)
            around = index(
                Oscillator(*points[part]),
                chart.curve_time.values[place],
                chart.curve_velocity.values[place],
                upper,
                radius,
            )
            vanish = kind == SpecialKind.SADDLE_NODE or response < 0.0
            assert abs(around) == (0 if vanish else 1), (kind, upper, points[part])
            seen[kind, vanish] = seen.get((kind, vanish), 0) + 1
    assert seen == {
        (SpecialKind.SADDLE_NODE, True): 12, (SpecialKind.GRAZING, True): 4, (SpecialKind.GRAZING, False): 6,
        (SpecialKind.PERIOD_DOUBLING, False): 6,
    }  # fmt: skip


def test_the_doubling_leads_to_an_orbit_of_twice_the_period(chart):
    (points,) = (points for kind, _, points in curves_of(chart) if kind == SpecialKind.PERIOD_DOUBLING)
    place = chart.curve_kind.values.tolist().index(KINDS.index(SpecialKind.PERIOD_DOUBLING) + 1)
    first = int(chart.curve_size.values[:place].sum())
    middle = len(points) // 2
    t, v = chart.curve_time.values[first + middle], chart.curve_velocity.values[first + middle]
    found = {}
    for side in (-1, 1):
        oscillator = Oscillator(points[middle, 0] + side * 3e-7, points[middle, 1])
        orbits = [find_orbit(oscillator, t + shift, v, 2) for shift in np.linspace(-1e-3, 1e-3, 41)]
        found[side] = {each.orbit.name for each in orbits if each is not None}
    assert ("P(2,2,2)" in found[-1]) != ("P(2,2,2)" in found[1])


def test_pixels_are_machines(chart):
    """Against the catalogue of a basin of the same departures. Transients can outlast one and not the other."""
    assert chart.quiet_share.dims == ("eccentricity", "damping") and chart.quiet_share.shape == (4, 4)
    seen = rattle.basin(
        damping=float(chart.damping[0]), eccentricity=float(chart.eccentricity[0]), cells=16, progress=False
    )  # fmt: skip
    motions = seen.rattle.attractors
    shares = dict(zip(motions.name.values.tolist(), motions.share.values.tolist(), strict=True))
    assert float(chart.quiet_share[0, 0]) == pytest.approx(shares["permanent contact"])
    assert chart.motion.values[0, 0] == "chaotic" and shares["chaotic"] > 0.0
    exponent = float(motions.lyapunov_exponent.values[motions.name.values.tolist().index("chaotic")])
    # One trajectory alone, of 512 impacts whose growths scatter by some 1.
    assert abs(float(chart.exponent[0, 0]) - exponent) < 4.0 / np.sqrt(512)


def test_a_motion_that_no_departure_meets_is_followed_from_the_machine_beside():
    """The basin of P(1,1,0) beside its graze is 0.7 % of the plane: 1024 departures see it, 16 do not."""
    (orbit,) = (
        found.orbit
        for found in find_orbits(Oscillator(0.7649, 0.096608), 1, (0.0, 1.0), (0.0, 7.0), 16)
        if found.orbit.attracts
    )
    row = machines_of_row(
        [Oscillator(damping, 0.096608) for damping in (0.7647, 0.76476, 0.7649)], 32, Region(), pause=lambda: None
    )
    alone = machines_of_row([Oscillator(0.7649, 0.096608)], 4, Region(), pause=lambda: None)
    assert np.isnan(alone["exponent"][0]) and alone["motion"][0] == "permanent contact"
    assert row["motion"][2] == orbit.name == "P(1,1,0)"
    assert row["exponent"][2] == pytest.approx(orbit.lyapunov_exponent, abs=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("reports", [1, 4, 9], ids="after {} reports".format)
def test_a_cancelled_chart_goes_on_to_the_same_bytes(client, store, tmp_path, reports):
    cancel, seen, location = threading.Event(), [], tmp_path / "chart.zarr"

    def cancel_soon(progress):
        seen.append(progress)
        if len(seen) == reports:
            cancel.set()

    with pytest.raises(JobCancelled):
        run(client, location, cancel_soon, cancel)
    assert not CHART.summary(str(location)).complete
    CHART.figure(str(location))
    run(client, location)
    assert content(location) == content(store)


def test_its_result_and_its_picture_say_the_same(store):
    told = CHART.summary(str(store))
    assert told.parameters == ("damping", "eccentricity") and told.lines_without_orbits == 0
    assert {(point.kind, point.orbit) for point in told.points} == {
        ("neutral graze", "P(1,1,0)"), ("saddle-node and graze", "P(1,1,0)"),
    }  # fmt: skip
    figure = CHART.figure(str(store))
    axes = figure.axes[0]
    assert axes.get_xlim() == (0.75, 0.78) and axes.get_ylim() == (0.094, 0.0995)
    listed = {text.get_text() for text in figure.legends[0].get_texts()}
    assert {text.get_text() for text in axes.texts} == {curve.orbit for curve in told.curves}
    assert {f"{curve.kind} of {curve.orbit}" for curve in told.curves} <= listed
    assert {point.kind for point in told.points} <= listed


def test_values_of_the_oscillator_that_the_chart_sets_itself_say_nothing():
    other = ChartJob(oscillator={"damping": 0.3, "eccentricity": 0.01}, **WINDOW, lines=2, pixels=4, departures=16)
    assert other.digest == JOB.digest
    assert ChartJob(**WINDOW, lines=2, pixels=5, departures=16).digest != JOB.digest


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"second": {"parameter": "damping", "start": 0.1, "stop": 0.2}}, "must be another than the first"),
        ({"first": {"parameter": "damping", "start": 0.78, "stop": 0.75}}, "must ascend"),
        ({"first": {"parameter": "restitution", "start": 0.9, "stop": 1.1}}, "restitution ends at 1"),
        ({"first": {"parameter": "backlash", "start": 0.1, "stop": 0.2}}, "backlash is no parameter"),
        ({"first": {"parameter": "amplitude_2", "start": 0.0, "stop": 0.1}}, "is none of its parameters"),
        ({"longest": 100}, "longest must be at most 99"),
        ({"pixels": -1}, "pixels must be 0 or more"),
        ({"second": {"parameter": "eccentricity", "start": 0.3, "stop": 0.9}}, "Eq. 8"),
    ],
)
def test_a_chart_that_cannot_be_drawn_is_refused(changed, told):
    with pytest.raises((InvalidJob, ValueError), match=told):
        ChartJob(**WINDOW | changed)


def test_in_python_two_numbers_are_pairs():
    with pytest.raises(InvalidJob, match="two parameters from where to where"):
        rattle.chart(damping=(0.7, 0.8))
    with pytest.raises(InvalidJob, match="damping is a pair"):
        rattle.chart(damping=(0.7, 0.8, 3), eccentricity=(0.09, 0.1))
