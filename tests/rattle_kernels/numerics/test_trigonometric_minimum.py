"""The least value of a trigonometric polynomial: known ones, and a mesh that never finds a lower one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rattle_kernels.numerics.trigonometric_minimum import TrigonometricPolynomial, least_value


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
