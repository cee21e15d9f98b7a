"""Least squares against LAPACK's, and where columns say the same or nothing."""

import numpy as np
import pytest

from rattle_kernels.numerics.least_squares import least_squares

LEAST = 1e-12


@pytest.mark.parametrize(("equations", "unknowns"), [(1280, 63), (64, 63), (7, 1)])
def test_coefficients_are_those_of_singular_values(equations, unknowns):
    rng = np.random.default_rng(equations)
    # Columns of lengths from 1e-9 to 1e9: only their directions matter.
    system = rng.normal(size=(equations, unknowns)) * 10.0 ** rng.uniform(-9.0, 9.0, unknowns)
    goal = rng.normal(size=equations)
    scale = np.linalg.norm(system, axis=0)
    exact, _, _, singular = np.linalg.lstsq(system / scale, goal, rcond=None)
    found = least_squares(system, goal, LEAST) * scale
    # Backward stable: rounding of the system, times its condition, and once more where something is left over.
    condition = singular[0] / singular[-1]
    error = 2.0**-52 * unknowns * condition * (1.0 + condition) * np.linalg.norm(goal)
    np.testing.assert_allclose(found, exact, rtol=0.0, atol=max(error, LEAST))
    assert np.abs(exact).max() > 1e3 * error


def test_what_the_equations_do_not_determine_stays_at_0():
    rng = np.random.default_rng(1)
    one, other = rng.normal(size=(2, 50))
    found = least_squares(np.column_stack([one, np.zeros(50), other, one]), 3.0 * one - 2.0 * other, LEAST)
    # Two columns that are the same share what is theirs. Rounding of some 1e-15 stands against rows of 1e-12.
    np.testing.assert_allclose(found, [1.5, 0.0, -2.0, 1.5], rtol=0.0, atol=0.01)
    assert found[0] + found[3] == pytest.approx(3.0, abs=1e-12)
