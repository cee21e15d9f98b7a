"""Curves of loose gears: where their points touch a wall or come to rest, and where P jumps."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rattle_kernels import FirstCurve, Oscillator, OutsideDomain, grazing_preimages, rest_velocity
from rattle_kernels.impact_map.flights import FORWARDS
from rattle_kernels.manifolds.curve_images import CurveMap, first_points, next_image
from rattle_kernels.manifolds.grazing_preimages import STRETCHES, preimages_of_stretch, speed_of_no_return
from rattle_kernels.manifolds.polyline import CurveResolution
from rattle_kernels.model.arcs import arcs_of, rest_acceleration_over_phases
from rattle_kernels.model.grazing_curve import largest_grazing_speed
from rattle_kernels.model.harmonics import Harmonic
from tests.rattle_kernels.impact_map.scalar_map import apply, bounce
from tests.rattle_kernels.manifolds.polylines import distance_to

ONE = Oscillator(eccentricity=0.4, restitution=0.7)
MACHINES = {
    "one harmonic": ONE,
    "elastic": Oscillator(eccentricity=0.3),
    "two harmonics": Oscillator(0.3, 0.15, 0.6, restitution=0.85, harmonics=(Harmonic(2.0, 0.06, 0.2),)),
}
RNG = np.random.default_rng(5)


def points_of(pieces, count, slowest=0.0):
    """Some points of pieces, none of them an end."""
    t, v = (np.concatenate([piece[axis][1:-1] for piece in pieces]) for axis in (0, 1))
    t, v = t[v > slowest], v[v > slowest]
    few = RNG.choice(t.size, min(count, t.size), replace=False)
    return t[few], v[few]


def bounces(oscillator, t, v, applications):
    for _ in range(applications):
        t, v = np.array([bounce(oscillator.in_kernels, *each).impact[:2] for each in zip(t, v, strict=True)]).T
    return t, v


def depth_of_first_touch(oscillator, wall, t, v):
    """How far an integrator's flights stay off a wall, or go beyond it, where they first turn close to it."""
    a, beta = rest_acceleration_over_phases(oscillator), oscillator.half_backlash
    y, closest = [beta, -v], math.inf

    def turning(_, state):
        return state[1]

    def striking(_, state):
        return state[0] + beta

    turning.terminal, striking.terminal, striking.direction = True, True, -1.0
    for _ in range(40):
        run = solve_ivp(
            lambda time, state: [state[1], float(a.at(np.array([time]))[0]) - oscillator.damping * state[1]],
            (t, t + 5.0), y, "DOP853", events=[turning, striking], rtol=1e-12, atol=1e-13, max_step=0.02,
        )  # fmt: skip
        t, (position, speed) = run.t[-1], run.y[:, -1]
        if run.t_events[0].size:
            closest = min(closest, abs(position - wall * beta))
            # Beyond +beta by more than rounding it is no flight any more.
            if closest < 1e-8 or position > beta + 1e-8:
                return closest
            # Off the turning point, at which the event would fire once more.
            bend = float(a.at(np.array([t]))[0])
            y, t = [position + 0.5 * bend * 1e-12, bend * 1e-6], t + 1e-6
        else:
            # A touch may strike by rounding: as deep as that speed would carry it.
            closest = min(closest, speed**2 / (2.0 * abs(float(a.at(np.array([t]))[0]))) if wall < 0.0 else math.inf)
            if closest < 1e-8:
                return closest
            y = [-beta, -oscillator.restitution * speed]
    return closest


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("first, wall", [(FirstCurve.LOWER, -1.0), (FirstCurve.UPPER, 1.0)])
def test_a_point_of_order_zero_touches_the_wall_by_an_ode_integrator(name, first, wall):
    """To 1e-8, a hundred times the error of the integrator."""
    oscillator = MACHINES[name]
    (pieces,) = grazing_preimages(oscillator, 0, first=first)
    # Flights of slower ones turn twice within a step.
    t, v = points_of(pieces, 12, slowest=0.1 * largest_grazing_speed(oscillator))
    assert t.size == 12
    followed = [depth_of_first_touch(oscillator, wall, *each) for each in zip(t, v, strict=True)]
    assert max(followed) < 1e-8


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("first", [FirstCurve.LOWER, FirstCurve.UPPER])
def test_a_point_of_order_n_lies_on_the_first_curve_after_n_bounces(name, first):
    """Bounce by bounce P leads a pre-image to the curve: within what a chord of the polyline is off, h alpha/8."""
    oscillator, resolution = MACHINES[name], CurveResolution()
    orders = grazing_preimages(oscillator, 2, first=first)
    scale = largest_grazing_speed(oscillator)
    for order in (1, 2):
        t, v = points_of(orders[order], 200)
        apart = distance_to(orders[0], *bounces(oscillator, t, v, order), scale)
        # P has a root at a graze on the way, and may jump there.
        assert np.quantile(apart, 0.98) < resolution.chord * resolution.angle / 8.0


def test_both_sides_of_the_edge_of_rest():
    """A little slower a departure of order n rests after n bounces, a little faster it does not."""
    orders = grazing_preimages(ONE, 2, first=FirstCurve.REST)
    for order, pieces in enumerate(orders):
        t, v = points_of(pieces, 50)
        t, v = bounces(ONE, t, v, order)
        edge = rest_velocity(ONE, t)
        assert (edge > 0.0).all()
        # Rounding grows by DP, some 10 for each application here, and by more where P has a root.
        assert np.quantile(np.abs(v - edge), 0.95) < 1e-9


@pytest.mark.parametrize("r", [0.6, 0.7, 0.9])
def test_edge_of_rest_has_its_closed_form_at_the_release(r):
    """With a = k s, s the time that is left, a bounce from v = c k s^2 takes x s, and leaves with the same c.

    c = x/2 - x^2/6 and (1 - x)^2 c = r (x/2 - x^2/3). Other terms of the flight are smaller by s.
    """
    oscillator = ONE._replace(restitution=r)
    x = brentq(lambda x: (1.0 - x) ** 2 * (0.5 - x / 6.0) - r * (0.5 - x / 3.0), 0.0, 1.0)
    arcs, a = arcs_of(oscillator), rest_acceleration_over_phases(oscillator)
    release = arcs.begin[arcs.sign < 0.0][0]
    k = -float(a.slope.at(np.array([release]))[0])
    off = [
        float(rest_velocity(oscillator, release - s)) / (k * s * s) / (x / 2.0 - x * x / 6.0) - 1.0
        for s in (1e-2, 1e-3, 1e-4)
    ]
    assert abs(off[2]) < 1e-3
    assert off[1] / off[0] == pytest.approx(0.1, rel=0.2) and off[2] / off[1] == pytest.approx(0.1, rel=0.05)


def test_where_nothing_presses_nothing_rests():
    arcs = arcs_of(ONE)
    middle = arcs.begin + 0.5 * np.diff(arcs.begin, append=arcs.begin[0] + 1.0)
    assert ((rest_velocity(ONE, middle) > 0.0) == (arcs.sign > 0.0)).all()
    assert (rest_velocity(ONE._replace(restitution=1.0), middle) == 0.0).all()


@pytest.mark.parametrize("name", MACHINES)
def test_an_image_breaks_off_where_a_flight_touches_the_upper_wall(name):
    """One end of the gap is a departure with hardly any speed, where nothing presses; P takes it to the other end."""
    oscillator = MACHINES[name]
    scale, arcs = largest_grazing_speed(oscillator), arcs_of(oscillator)
    (pieces,) = grazing_preimages(oscillator, 0, first=FirstCurve.UPPER)
    middle = max(pieces, key=lambda piece: piece.v.max())
    at = int(np.argmax(middle.v)) - 2 if middle.v.argmax() > 2 else middle.t.size // 2
    t, v = middle.t[at], middle.v[at]
    across = first_points(np.array([t, t]), np.array([0.99 * v, 1.01 * v]))
    forwards = CurveMap(oscillator, FORWARDS, 1, 0.0, scale)
    image = next_image(forwards, across, CurveResolution(), 10_000)
    ends = np.flatnonzero(~image.joined[:-1])
    assert ends.size >= 1
    found = False
    for end in ends:
        sides = [(image.t[-1, i] % 1.0, image.v[-1, i]) for i in (end, end + 1)]
        slow, other = sorted(sides, key=lambda side: side[1])
        # The square root of the distance between neighbouring numbers.
        if slow[1] < 1e-6 * scale:
            pressed = arcs.sign[np.searchsorted(arcs.begin, slow[0], side="right") - 1]
            landed = bounces(oscillator, [slow[0]], [slow[1]], 1)
            found = pressed < 0.0 and abs(landed[1][0] - other[1]) < 1e-5 * scale
            if found:
                break
    assert found


def test_stretches_are_the_whole():
    whole = grazing_preimages(ONE, 1, first=FirstCurve.UPPER)
    parts = [preimages_of_stretch(ONE, 1, each, first=FirstCurve.UPPER) for each in range(STRETCHES)]
    for order, pieces in enumerate(whole):
        length = sum(np.hypot(np.diff(p.t), np.diff(p.v)).sum() for p in pieces)
        of_parts = sum(np.hypot(np.diff(p.t), np.diff(p.v)).sum() for part in parts for p in part[order])
        assert of_parts == pytest.approx(length, rel=1e-3)


@pytest.mark.parametrize("name", MACHINES)
def test_backwards_all_speeds_rise_above_the_speed_of_no_return(name):
    oscillator = MACHINES[name]
    t, v = RNG.random(200), speed_of_no_return(oscillator) * RNG.uniform(1.0, 5.0, 200)
    assert (apply(oscillator.in_kernels, t, v, -1)[1] > v).all()


@pytest.mark.parametrize(
    "oscillator, first, message",
    [
        (Oscillator(), FirstCurve.UPPER, "eccentricity must be above epsilon_crit2 = 0.190121"),
        (Oscillator(), FirstCurve.REST, "eccentricity must be above"),
        (Oscillator(eccentricity=0.4), FirstCurve.REST, "restitution must be below 1"),
    ],
)
def test_what_has_no_such_curve_is_refused(oscillator, first, message):
    with pytest.raises(OutsideDomain, match=message):
        grazing_preimages(oscillator, 1, first=first)
