"""Below the speed of capture every departure falls quiet; nothing is claimed where nothing is proven."""

import numpy as np
import pytest

from rattle_kernels import (
    Oscillator,
    Outcome,
    OutsideDomain,
    capture_velocity,
    grazing_velocity,
    next_impacts,
    tangent_growth,
)

PHASES = np.arange(8) / 8


@pytest.mark.parametrize("stiffness", [np.inf, 1e6], ids=["impacting", "piecewise linear"])
def test_departures_below_it_fall_quiet_and_shortcuts_end_them_at_once(stiffness):
    oscillator = Oscillator(stiffness=stiffness)
    speeds = capture_velocity(oscillator, PHASES)
    assert ((speeds > 0.0) & (speeds < grazing_velocity(oscillator, PHASES))).all()
    landed = next_impacts(oscillator, PHASES, 0.999 * speeds, 100_000, shortcuts=True)
    assert (landed.outcome == Outcome.PERMANENT_CONTACT).all()


def test_shortcuts_lead_where_every_impact_leads():
    t, v = np.array([0.2, 0.898, 0.7]), np.array([1.0, 3.77, 5.5])
    short, whole = (next_impacts(Oscillator(), t, v, 3001, shortcuts=shortcuts) for shortcuts in (True, False))
    assert short.outcome[0] == Outcome.PERMANENT_CONTACT
    locked = short.outcome == Outcome.RETURNED
    assert locked.any()
    # On the periodic orbit both have the error of its own rounding; on the way to it nothing is skipped.
    np.testing.assert_allclose(short.v[1], whole.v[1], rtol=1e-9)


def test_of_soft_contact_nothing_is_proven_and_phases_keep_their_shape():
    assert (capture_velocity(Oscillator(stiffness=100.0), PHASES) == 0.0).all()
    assert capture_velocity(Oscillator(), [[0.1, 1.1]]).shape == (1, 2)
    assert float(capture_velocity(Oscillator(), 0.1)) == pytest.approx(float(capture_velocity(Oscillator(), 1.1)))
    with pytest.raises(OutsideDomain, match="damping must be positive"):
        capture_velocity(Oscillator(damping=0.0), 0.1)


def test_what_is_no_departure_has_no_growth():
    growth = tangent_growth(Oscillator(), [0.553, np.nan, 0.553], [4.703, 4.703, -1.0], 40).growth
    assert np.isnan(growth).tolist() == [False, True, True]
    with pytest.raises(ValueError, match="impacts must be at least 1"):
        tangent_growth(Oscillator(), [0.5], [4.0], 0)
