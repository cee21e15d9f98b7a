"""Arcs of a loose gear: where they begin, their signs and bounds, and the time that is left on one."""

import math

import numpy as np
import pytest

from rattle_kernels import Oscillator, eccentricity_bound_smooth_maxima
from rattle_kernels.model.arcs import (
    arcs_of,
    is_pressed,
    phase_of_release,
    rest_acceleration_over_phases,
    time_to_release,
)
from tests.rattle_kernels.impact_map.test_loose_map import random_machine


@pytest.mark.parametrize("seed", range(20))
def test_acceleration_keeps_its_sign_on_an_arc_and_its_bounds(seed):
    oscillator, *_ = random_machine(seed)
    arcs, felt = arcs_of(oscillator), rest_acceleration_over_phases(oscillator)
    mesh = (np.arange(10_000) + 0.5) / 10_000
    on = np.searchsorted(arcs.begin, mesh, side="right") - 1
    clear = np.abs(felt.at(mesh)) > 1e-12 * felt.size
    assert (np.sign(felt.at(mesh)) == arcs.sign[on])[clear].all()
    assert np.abs(felt.at(mesh)).max() <= arcs.strongest and np.abs(felt.slope.at(mesh)).max() <= arcs.change
    assert arcs.begin.size <= 2.0 * max(order for order, *_ in oscillator.all_harmonics)


@pytest.mark.parametrize("gamma", [1.0 + 1e-12, 1.01, 1.5, 4.0])
def test_arcs_of_one_harmonic_are_where_inertia_is_drag(gamma):
    oscillator = Oscillator()
    oscillator = oscillator.at(eccentricity=gamma * eccentricity_bound_smooth_maxima(oscillator))
    arcs = arcs_of(oscillator)
    # a = 4 pi delta (1 + gamma cos(2 pi t - turn)): negative for acos(1/gamma)/pi of a period.
    negative = math.acos(1.0 / gamma) / math.pi
    lengths = np.diff(arcs.begin, append=arcs.begin[0] + 1.0)
    assert arcs.begin.size == 2 and sorted(arcs.sign) == [-1.0, 1.0]
    # Next to the bound a zero is as good as the root of rounding.
    assert lengths[arcs.sign < 0.0] == pytest.approx(negative, abs=1e-15 / math.sqrt(gamma - 1.0) + 1e-14)


def test_at_the_bound_itself_there_is_one_arc_that_never_ends():
    oscillator = Oscillator()
    at = oscillator.at(eccentricity=eccentricity_bound_smooth_maxima(oscillator))
    arcs = arcs_of(at)
    assert arcs.sign.tolist() == [1.0]
    assert time_to_release(arcs, 0.3) == math.inf and is_pressed(arcs, 1.0, 0.3) and not is_pressed(arcs, -1.0, 0.3)
    assert arcs_of(oscillator) is None


def test_a_pressed_gear_is_released_where_the_next_arc_begins():
    arcs = arcs_of(Oscillator(eccentricity=0.5))
    for phase in np.arange(100) / 100:
        release = phase_of_release(arcs, phase)
        assert release in arcs.begin
        assert (phase + time_to_release(arcs, phase) - release) % 1.0 == pytest.approx(0.0, abs=1e-15) or (
            phase + time_to_release(arcs, phase) - release
        ) % 1.0 == pytest.approx(1.0, abs=1e-15)
        assert time_to_release(arcs, phase) > 0.0
