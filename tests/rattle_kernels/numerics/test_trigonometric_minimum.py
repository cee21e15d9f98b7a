"""The least value and the changes of sign of a trigonometric polynomial: known ones, and what a fine mesh finds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rattle_kernels.numerics.trigonometric_minimum import TrigonometricPolynomial, changes_of_sign, least_value


def test_known_minima():
    one = TrigonometricPolynomial(2.0, np.array([1.0]), np.array([1.0]), np.array([0.0]))
    assert least_value(one) == (pytest.approx(1.0, abs=1e-13), pytest.approx(0.5, abs=1e-6))
    # cos + cos(2 .)/2 is 2 c^2/2 + c - 1/2 with c = cos: least at c = -1/2, where it is -3/4.
    two = TrigonometricPolynomial(0.0, np.array([1.0, 2.0]), np.array([1.0, 0.5]), np.zeros(2))
    value, phase = least_value(two)
    assert value == pytest.approx(-0.75, abs=1e-13) and np.cos(2 * np.pi * phase) == pytest.approx(-0.5, abs=1e-6)


@given(arrays(np.float64, 4, elements=st.floats(-1, 1)), arrays(np.float64, 4, elements=st.floats(-1, 1)))
def test_no_mesh_finds_a_lower_value(cosine, sine):
    polynomial = TrigonometricPolynomial(0.3, np.array([1.0, 2.0, 3.0, 7.0]), cosine, sine)
    value, phase = least_value(polynomial)
    assert polynomial.at(np.arange(20_000) / 20_000).min() >= value - 1e-13 * polynomial.size
    assert polynomial.at(np.array([phase]))[0] == pytest.approx(value, abs=1e-13 * polynomial.size)


@pytest.mark.parametrize("amplitude", [np.inf, 1e306, 5e307])
def test_what_overflows_has_no_least_value(amplitude):
    huge = TrigonometricPolynomial(0.0, np.array([95.0, 2.0]), np.array([amplitude, 0.0]), np.array([amplitude, 0.0]))
    with np.errstate(over="ignore", invalid="ignore"):
        assert np.isnan(least_value(huge)[0])


@pytest.mark.parametrize("mean", [-0.9, -0.3, 0.0, 1e-3, 0.5, 0.99])
@pytest.mark.parametrize("order", [1, 2, 5])
def test_known_changes_of_sign(mean, order):
    shifted = TrigonometricPolynomial(mean, np.array([float(order)]), np.array([0.6]), np.array([0.8]))
    # cos(2 pi (order t - s)) = -mean with tan 2 pi s = 4/3.
    turn, half = np.arctan2(0.8, 0.6) / (2 * np.pi), np.arccos(-mean) / (2 * np.pi)
    known = np.sort([(turn + sign * half + k) / order % 1.0 for sign in (-1, 1) for k in range(order)])
    np.testing.assert_allclose(changes_of_sign(shifted), known, atol=1e-14)


@pytest.mark.parametrize("mean", [1.5, -2.0])
def test_what_keeps_its_sign_has_no_change_of_it(mean):
    assert changes_of_sign(TrigonometricPolynomial(mean, np.array([1.0]), np.array([1.0]), np.array([0.0]))).size == 0


@pytest.mark.parametrize("mean", [1.0, -1.0])
def test_a_double_zero_is_none_or_two_within_rounding(mean):
    touching = TrigonometricPolynomial(mean, np.array([1.0]), np.array([1.0]), np.array([0.0]))
    found = changes_of_sign(touching)
    # 1 + cos differs from 0 by rounding for some 1e-8 of a turn.
    assert found.size == 0 or (found.size == 2 and np.ptp(found) < 1e-7)


def test_zeros_close_together_are_both_found():
    # 1 + cos less 2 d^2 has two at pi -+ 2 d to first order.
    for d in (1e-2, 1e-4, 1e-6):
        close = TrigonometricPolynomial(1.0 - 2.0 * d * d, np.array([1.0]), np.array([1.0]), np.array([0.0]))
        found = changes_of_sign(close)
        assert found.size == 2 and np.diff(found)[0] == pytest.approx(2.0 * d / np.pi, rel=1e-3)


@given(
    st.floats(-2, 2),
    arrays(np.float64, 4, elements=st.floats(-1, 1)),
    arrays(np.float64, 4, elements=st.floats(-1, 1)),
)
def test_a_fine_mesh_finds_no_other_change_of_sign(mean, cosine, sine):
    polynomial = TrigonometricPolynomial(mean, np.array([1.0, 2.0, 3.0, 32.0]), cosine, sine)
    found = changes_of_sign(polynomial)
    assert found.size % 2 == 0 and found.size <= 64
    assert (np.diff(found) > 0.0).all() and ((0.0 <= found) & (found < 1.0)).all()
    mesh = (np.arange(20_000) + 0.5) / 20_000
    values = polynomial.at(mesh)
    # Signs alternate from one to the next; where the mesh sees less than rounding it tells nothing.
    expected = (-1.0) ** np.searchsorted(found, mesh) * (np.sign(polynomial.at(np.zeros(1)))[0] or 1.0)
    clear = np.abs(values) > 1e-12 * polynomial.size
    if found.size:
        first = np.flatnonzero(clear)[0]
        expected *= np.sign(values[first]) * expected[first]
        assert (np.sign(values[clear]) == expected[clear]).all()
        assert np.abs(polynomial.at(found)).max() <= 1e-13 * polynomial.size * 32
    else:
        assert np.unique(np.sign(values[clear])).size <= 1


def test_a_zero_at_phase_0_is_not_lost_between_its_two_sides():
    # The sum is positive at 0, and at 1 rounding makes it negative.
    order, cosine, sine = np.array([1.0, 3.0, 32.0]), np.array([1e-17, 0.0, 0.0]), np.array([1.0, -1.0, 1.0])
    found = changes_of_sign(TrigonometricPolynomial(0.0, order, cosine, sine))
    # The sum is odd but for 1e-17: with a zero there is its opposite.
    assert np.abs((found + 0.5) % 1.0 - 0.5).min() < 1e-15
    np.testing.assert_allclose(np.sort((-found) % 1.0 % (1.0 - 1e-12)), found, atol=1e-12)


def test_a_double_zero_in_the_middle_hides_no_others():
    # cos 3 + cos 32 is 2 cos 17.5 cos 14.5: both factors vanish at 1/2.
    order, amplitude = np.array([3.0, 32.0]), np.array([1.0, 1.0])
    found = changes_of_sign(TrigonometricPolynomial(0.0, order, amplitude, np.zeros(2)))
    known = sorted({(2 * k + 1) / 70 for k in range(35)} ^ {(2 * k + 1) / 58 for k in range(29)})
    away = found[np.abs(found - 0.5) > 1e-7]
    np.testing.assert_allclose(away, known, atol=1e-13)
