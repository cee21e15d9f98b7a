"""A measured curve becomes the harmonics that it was made of, and what is left out is said."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rattle_kernels import (
    AngleUnit,
    Oscillator,
    OutsideDomain,
    TransmissionError,
    UnusableCurve,
    check_domain,
    transmission_error,
)

TWO_PI = 2.0 * math.pi
PER_TURN = {"turns": 1.0, "degrees": 360.0, "radians": TWO_PI}
MADE_OF = ((1, 0.1, 0.3), (2, 0.02, 0.1), (3, 0.01, 0.85))
# Time begins where the first order is largest: at -0.3 turns.
SHIFTED = {2: (0.02, 0.1 - 2 * 0.3), 3: (0.01, 0.85 - 3 * 0.3)}


def curve(turns, components=MADE_OF, mean=3.0):
    turns = np.asarray(turns)
    return mean + sum(size * np.cos(TWO_PI * (order * turns + phase)) for order, size, phase in components)


def angles_of(way, random):
    return {
        "a turn": np.arange(24) / 24,
        "a turn and its end": np.linspace(0.0, 1.0, 25),
        "three turns": np.arange(72) / 24 - 1.0,
        "one turn and a third": np.linspace(0.0, 4.0 / 3.0, 37),
        "seven samples": np.arange(7) / 7,
        "unequal": np.sort(random.uniform(0.0, 2.0, 200)),
        "turns that interleave": np.arange(22) / 5.5,
    }[way]


WAYS = (
    "a turn", "a turn and its end", "three turns", "one turn and a third", "seven samples", "unequal",
    "turns that interleave",
)  # fmt: skip


@pytest.mark.parametrize("unit", AngleUnit)
@pytest.mark.parametrize("way", WAYS)
def test_the_orders_that_made_a_curve_are_found(way, unit):
    turns = angles_of(way, np.random.default_rng(4))
    found = transmission_error(turns * PER_TURN[unit], 100.0 * curve(turns), unit=unit, explained=1.0, scale=0.01)
    assert found.orders == (1, 2, 3) and found.scale == 0.01
    assert found.eccentricity == pytest.approx(0.1, abs=1e-12) and found.shift == pytest.approx(0.7, abs=1e-12)
    for order, amplitude, phase in found.harmonics:
        size, where = SHIFTED[int(order)]
        assert amplitude == pytest.approx(size, abs=1e-12)
        assert abs((phase - where + 0.5) % 1.0 - 0.5) < 1e-11 and 0.0 <= phase < 1.0
    assert found.explained == pytest.approx(1.0) and found.left_out.rms < 1e-13


def test_in_its_own_time_the_forcing_is_the_curve():
    turns = np.arange(90) / 90
    found = transmission_error(turns, curve(turns), explained=1.0)
    own = ((1, found.eccentricity, 0.0), *found.harmonics)
    np.testing.assert_allclose(curve(turns - found.shift, own), curve(turns), atol=1e-10)


@pytest.mark.parametrize(
    ("explained", "orders", "left"), [(0.9, (1,), (2, 0.02)), (0.97, (1, 2), (3, 0.01)), (0.999, (1, 2, 3), None)]
)
def test_the_fewest_orders_that_explain_enough_are_kept(explained, orders, left):
    """Their parts of the variance are as the squares: 100 to 4 to 1."""
    turns = np.arange(40) / 40
    found = transmission_error(turns, curve(turns), explained=explained)
    squares = {1: 100, 2: 4, 3: 1}
    part = sum(squares[order] for order in orders) / 105
    assert found.orders == orders and found.explained == pytest.approx(part) and found.explained >= explained
    assert found.left_out.rms == pytest.approx(math.sqrt(0.5 * 1e-4 * 105 * (1.0 - part)), abs=1e-10)
    if left:
        assert found.left_out[:2] == pytest.approx(left)


def test_a_large_second_order_alone_has_no_eccentricity_and_no_shift():
    turns = np.arange(32) / 32
    found = transmission_error(turns, curve(turns, ((1, 0.001, 0.2), (2, 0.1, 0.4))), explained=0.9)
    assert found.orders == (2,) and found.eccentricity == found.shift == 0.0
    assert found.harmonics[0] == pytest.approx((2.0, 0.1, 0.4)) and found.left_out.order == 1


@given(st.integers(1, 9), st.integers(0, 30))
def test_orders_are_looked_for_up_to_half_the_samples_of_a_turn(order, more):
    count = 2 * order + 1 + more
    turns = np.arange(count) / count
    found = transmission_error(turns, np.cos(TWO_PI * order * turns), explained=1.0)
    assert found.highest == (count - 1) // 2 and found.orders == (order,)


def test_noise_is_left_out_with_its_size():
    random = np.random.default_rng(3)
    turns, noise = np.arange(720) / 360, random.normal(0.0, 1e-3, 720)
    found = transmission_error(turns, curve(turns) + noise, explained=0.999)
    assert found.orders == (1, 2, 3)
    # A variance of 720 normal numbers has a relative error of sqrt(2/720); five of them.
    assert found.left_out.rms**2 == pytest.approx(1e-6, rel=5 * math.sqrt(2 / 720))
    with pytest.raises(UnusableCurve, match=r"orders up to 179, .* explain 0.9999.* not 1: lower explained"):
        transmission_error(turns, curve(turns) + noise, explained=1.0)


@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_whether_eq_8_holds_is_what_the_door_says(scale):
    turns = np.arange(64) / 64
    found = transmission_error(turns, curve(turns, ((1, 0.1, 0.3), (2, 0.01, 0.1))), explained=1.0, scale=scale)
    least, phase = found.least_acceleration(0.6)
    time = np.linspace(0.0, 1.0, 20001)
    felt = 4.0 * math.pi * 0.6 + 0.0 * time
    for order, size, start in ((1, found.eccentricity, 0.0), *found.harmonics):
        rate, angle = TWO_PI * order, TWO_PI * (order * time + start)
        felt -= size * rate * (rate * np.cos(angle) + 0.6 * np.sin(angle))
    # Between two of these a value may lie lower by the curvature over eight: at most 400 (2.5e-9)/8 times 10.
    assert least == pytest.approx(felt.min(), abs=2e-6) and phase == pytest.approx(time[felt.argmin()], abs=1e-3)
    oscillator = Oscillator(damping=0.6, **found.forcing)
    if least > 0.0:
        assert check_domain(oscillator).harmonics == found.harmonics
    else:
        assert scale == 2.0
        with pytest.raises(OutsideDomain, match="Eq. 8"):
            check_domain(oscillator)


@pytest.mark.parametrize(
    ("angle", "error", "options", "told", "sample"),
    [
        ([0.0, 0.5], [1.0, 2.0], {}, "at least three samples, not 2", None),
        ([0.0, 0.3, 0.6], [1.0, 2.0], {}, "as long as each other, not 3 and 2", None),
        ([0.0, 0.3, math.nan], [1.0, 2.0, 3.0], {}, "angle must be finite, not nan", 2),
        ([0.0, 0.3, 0.6], [1.0, math.inf, 3.0], {}, "error must be finite, not inf", 1),
        ([0.0, 0.3, 0.3], [1.0, 2.0, 3.0], {}, "angle must increase: 0.3 follows 0.3", 2),
        ([0.0, 0.3, 0.6], [1.0, 2.0, 3.0], {"unit": "gon"}, "one of turns, degrees, radians, not 'gon'", None),
        ([0.0, 0.3, 0.6], [1.0, 2.0, 3.0], {"explained": 1.1}, "at most 1, not 1.1", None),
        ([0.0, 0.3, 0.6], [1.0, 2.0, 3.0], {"explained": math.nan}, "at most 1, not nan", None),
        ([0.0, 0.3, 0.6], [1.0, 2.0, 3.0], {"scale": 0.0}, "not 0, not 0", None),
        ([0.0, 0.3, 0.6], [2.0, 2.0, 2.0], {}, "the same at every angle", None),
        ([0.0, 0.2, 0.4], [1.0, 2.0, 3.0], {}, "after 0.4 turns none follows for 0.6", None),
        (range(360), range(360), {}, "none follows for 1. They are read as turns", None),
        (range(360), range(360), {"unit": "radians"}, "explain 0.", None),
    ],
)  # fmt: skip
def test_a_curve_that_says_nothing_is_refused(angle, error, options, told, sample):
    with pytest.raises(UnusableCurve, match=told) as refused:
        transmission_error(list(angle), list(error), **options)
    assert refused.value.sample == sample and isinstance(refused.value, ValueError)
    again = pickle.loads(pickle.dumps(refused.value))
    assert str(again) == str(refused.value) and again.sample == sample


def test_units_of_one_curve_give_equal_numbers():
    """So that equal forcings are equal requests."""
    turns = np.arange(90) / 90
    found = {
        unit: transmission_error(turns * PER_TURN[unit], curve(turns), unit=unit, explained=1.0).forcing
        for unit in AngleUnit
    }
    assert found["turns"] == found["degrees"] == found["radians"]
    assert isinstance(transmission_error(turns, curve(turns)), TransmissionError)
