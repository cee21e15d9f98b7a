"""Forcings of machines: sums of orders, two gears, and torque ripple against an integrator of Eq. (1)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from rattle_kernels import Harmonic, Oscillator, eccentric_gears, next_impacts, time_history, torque_ripple
from rattle_kernels.model.forcing import shifted_forcing

TWO_PI = 2.0 * math.pi
TIMES = np.linspace(0.0, 1.0, 101)
components = st.lists(
    st.builds(Harmonic, st.integers(1, 6), st.floats(-0.2, 0.2), st.floats(-3.0, 3.0)), min_size=1, max_size=6
)


def curve(harmonics, time):
    return sum(
        (amplitude * np.cos(TWO_PI * (order * time + phase)) for order, amplitude, phase in harmonics), 0.0 * time
    )


@given(components)
def test_a_sum_of_orders_is_the_same_curve_from_another_time_on(given_components):
    forcing, shift = shifted_forcing(given_components)
    assert 0.0 <= shift < 1.0
    orders = [harmonic.order for harmonic in forcing["harmonics"]]
    assert orders == sorted(set(orders)) and min(orders, default=2) >= 2
    own = (Harmonic(1, forcing["eccentricity"]), *forcing["harmonics"])
    # Six numbers each rounded to 12 digits: an amplitude of at most 1.2, and a phase of at most 1e-12/2 periods.
    bound = 6 * (1.2 * TWO_PI * 0.5e-12 + 0.5e-12 * 1.2) + 1e-13
    np.testing.assert_allclose(curve(own, TIMES), curve(given_components, TIMES + shift), rtol=0.0, atol=bound)


def test_two_gears_are_the_orders_by_which_they_turn():
    assert eccentric_gears(2, 3, 0.02, 0.01, 0.25) == {
        "eccentricity": 0.0, "harmonics": (Harmonic(2.0, 0.02, 0.0), Harmonic(3.0, 0.01, 0.25)),
    }  # fmt: skip
    # The second gear is the slower one here, so time begins where its eccentricity is largest.
    swapped = eccentric_gears(2, 1, 0.01, 0.1, 0.125)
    assert swapped == {"eccentricity": 0.1, "harmonics": (Harmonic(2.0, 0.01, 0.75),)}
    opposed = eccentric_gears(1, 1, 0.1, 0.06, 0.25)
    assert eccentric_gears(1, 1, 0.1, 0.1, 0.5) == {"eccentricity": 0.0, "harmonics": ()}
    assert opposed["eccentricity"] == pytest.approx(math.hypot(0.1, 0.06), rel=1e-11) and opposed["harmonics"] == ()


@pytest.mark.parametrize(
    ("p", "q", "assembly"),
    [pytest.param(*given, marks=pytest.mark.slow) for given in ((3, 2, 0.3), (2, 5, 0.85), (5, 3, 0.0))],
)
def test_two_gears_in_the_units_of_one_turn_of_the_first_are_the_same_machine(p, q, assembly):
    """A flight by DOP853 as one turn of the first gear tells time; its forcing is the way that both centres move."""
    damping, first, second, half_backlash = 0.25, 0.03, 0.004, 0.4
    line_of_action = np.array([math.cos(0.35), math.sin(0.35)])

    def along(length, turns):
        """Where a gear's centre is along the line of action, its speed and its acceleration, per turn of the first."""
        place = [np.array([math.cos(TWO_PI * turn + 0.35), math.sin(TWO_PI * turn + 0.35)]) for turn in turns]
        return length * np.array([line_of_action @ each for each in place])

    # A quarter of a turn ahead is the derivative, per radian.
    def motion(time, state):
        total = 4.0 * math.pi * damping
        for length, ratio, lead in ((first, 1.0, 0.0), (second, q / p, assembly)):
            turn, rate = ratio * time + lead, TWO_PI * ratio
            _, speed, acceleration = along(length, [turn, turn + 0.25, turn + 0.5]) * [1.0, rate, rate**2]
            total += acceleration + damping * speed
        return [state[1], total - damping * state[1]]

    def back(time, state):
        return state[0] - half_backlash

    back.terminal, back.direction = True, 1.0
    start, speed = 0.7, 1.1
    flight = solve_ivp(
        motion, (start, start + 20), [half_backlash, -speed], method="DOP853", rtol=1e-12, atol=1e-12, events=back
    )
    assert flight.y[0].min() > -half_backlash
    oscillator = Oscillator(
        p * damping, half_backlash=half_backlash / p, **eccentric_gears(p, q, first / p, second / p, assembly)
    )
    # Speeds are lengths a period: both are p times as long, so they stay.
    impact = next_impacts(oscillator, start / p, speed)
    assert float(impact.t) == pytest.approx(flight.t[-1] / p % 1.0, abs=1e-9)
    assert float(impact.v) == pytest.approx(flight.y[1, -1], rel=1e-8) and impact.lower_impacts == 0


@pytest.mark.parametrize(("p", "q"), [(2, 4), (0, 1), (1.5, 1), (-1, 2)])
def test_gears_that_do_not_turn_so_are_refused(p, q):
    with pytest.raises(ValueError, match="without a common divisor"):
        eccentric_gears(p, q, 0.1, 0.1)


@pytest.mark.parametrize(("order", "torque", "phase"), [(2, 0.9, 0.3), (5, 2.0, 0.0), (3, -1.2, 0.8)])
@pytest.mark.parametrize("stiffness", [math.inf, 200.0])
def test_torque_ripple_moves_as_an_integrator_with_that_torque(order, torque, phase, stiffness):
    """DOP853 has the torque on the right side of Eq. (1), and no harmonic: a flight, and a contact with a spring."""
    damping, eccentricity, half_backlash = 0.6, 0.08, 0.6
    ripple = torque_ripple(order, torque, phase, damping)
    oscillator = Oscillator(damping, eccentricity, half_backlash, stiffness, harmonics=(ripple,))
    start, speed = 0.2, 2.5
    history = time_history(oscillator, start, half_backlash, -speed, periods=1.0)
    first, *others = history.contacts.time
    last = first if math.isinf(stiffness) else others[0]

    def motion(time, state, spring):
        drive = 4.0 * math.pi * damping - TWO_PI * eccentricity * (
            TWO_PI * math.cos(TWO_PI * time) + damping * math.sin(TWO_PI * time)
        )
        ripple = torque * math.cos(TWO_PI * (order * time + phase))
        return [state[1], drive + ripple - damping * state[1] - 2.0 * spring * (state[0] - half_backlash)]

    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-12, "dense_output": True}
    flight = solve_ivp(motion, (start, first), [half_backlash, -speed], args=(0.0,), **options)
    pieces = [flight]
    if last > first:
        pieces.append(solve_ivp(motion, (first, last), flight.y[:, -1], args=(stiffness,), **options))
    for piece, (begin, end) in zip(pieces, ((start, first), (first, last)), strict=False):
        inside = (history.time > begin) & (history.time < end)
        assert inside.sum() > 5
        displacement, velocity = piece.sol(history.time[inside])
        np.testing.assert_allclose(history.displacement[inside], displacement, atol=1e-9)
        np.testing.assert_allclose(history.velocity[inside], velocity, atol=1e-8)


def test_ripple_of_no_whole_order_is_refused():
    with pytest.raises(ValueError, match="whole numbers from 1 on, not 1.5"):
        torque_ripple(1.5, 1.0, 0.0, 0.6)
