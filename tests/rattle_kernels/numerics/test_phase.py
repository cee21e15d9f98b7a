"""Phases are wrapped into [0, 1), never to 1.0."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rattle_kernels.numerics.phase import part_turn, wrap, wrap_all

finite = st.floats(-1e6, 1e6)


def around_the_circle(one, other):
    apart = abs(one - other)
    return min(apart, 1.0 - apart)


@pytest.mark.parametrize("phase", [-1e-17, -5e-324, -1.1e-16])
def test_a_phase_just_below_a_whole_period_is_wrapped_to_its_beginning(phase):
    assert wrap(phase) < 1.0
    assert around_the_circle(wrap(phase), 0.0) <= 1.2e-16
    assert wrap_all(np.array([phase]))[0] == wrap(phase)


def test_what_rounds_up_to_one_becomes_zero():
    assert -1e-17 - math.floor(-1e-17) == 1.0
    assert wrap(-1e-17) == 0.0


@given(finite)
def test_wrapped_phases_lie_in_the_first_period(phase):
    assert 0.0 <= wrap(phase) < 1.0
    assert wrap_all(np.array([phase]))[0] == wrap(phase)


@given(finite)
def test_a_whole_period_makes_no_difference(phase):
    assert around_the_circle(wrap(phase + 1.0), wrap(phase)) <= 4.0 * np.spacing(1.0 + abs(phase))


@given(st.floats(0.0, 1.0, exclude_max=True))
def test_wrapping_leaves_the_first_period_alone(phase):
    assert wrap(phase) == phase


@given(finite)
def test_part_turns_are_half_a_turn_at_most(turns):
    assert abs(part_turn(turns)) <= 0.5
    assert around_the_circle(wrap(part_turn(turns)), wrap(turns)) <= 2.0 * np.spacing(1.0 + abs(turns))


def test_what_is_not_a_number_stays_so():
    assert math.isnan(wrap(math.nan)) and math.isnan(wrap_all(np.array([math.nan]))[0])
