"""Maps of shares over two parameters show each basin at its own values: of a sweep that is not square."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from rattle_kernels import Attractor, AttractorKind, ExpectedLoudness
from worker.jobs.basin_job import SweepJob
from worker.jobs.swept_parameter import SweptParameter
from worker.results.shares import _draw_maps

FIRST, LAST = (0.55, 0.6), (0.08, 0.09, 0.1)
JOB = SweepJob(vary=(SweptParameter("damping", FIRST), SweptParameter("eccentricity", LAST)))
NONE = np.empty(0)
MOTIONS = (
    Attractor(AttractorKind.PERMANENT_CONTACT, 0, 0, 0, np.nan, np.nan, NONE, NONE),
    Attractor(AttractorKind.PERIODIC, 1, 1, 0, -0.3, 0.0, np.array([0.9]), np.array([3.7])),
)


@pytest.fixture(scope="module")
def figure():
    quiet = np.array([[0.31, 0.42, 0.53], [0.64, 0.75, 0.86]])
    fields = ExpectedLoudness._fields
    expected = [
        ExpectedLoudness(**dict.fromkeys(fields, 0.0) | {"impact_power": 10.0 + basin}) for basin in range(JOB.basins)
    ]
    drawn = Figure()
    _draw_maps(drawn, JOB, np.stack([quiet, 1.0 - quiet], axis=-1), MOTIONS, expected, {})
    return drawn, quiet


def shown(axes):
    """Value of each cell by (x, y) of its centre."""
    (mesh,) = axes.collections
    corners = mesh.get_coordinates()
    centres = corners[:-1, :-1] / 2 + corners[1:, 1:] / 2
    return {
        (round(float(x), 9), round(float(y), 9)): float(value)
        for (x, y), value in zip(centres.reshape(-1, 2), np.ravel(mesh.get_array()), strict=True)
    }


def test_each_share_and_the_power_stand_at_their_own_values(figure):
    drawn, quiet = figure
    titles = {axes.get_title(): axes for axes in drawn.axes if axes.get_title()}
    assert sorted(titles) == ["0: permanent contact", "1: P(1,1,0)", "expected impact power"]
    for title, values in (
        ("0: permanent contact", quiet),
        ("1: P(1,1,0)", 1.0 - quiet),
        ("expected impact power", 10.0 + np.arange(6.0).reshape(2, 3)),
    ):
        told = {(x, y): values[i, j] for i, y in enumerate(FIRST) for j, x in enumerate(LAST)}
        assert shown(titles[title]) == pytest.approx(told), title


def test_axes_are_named_after_their_parameters(figure):
    drawn, _ = figure
    assert (drawn.get_supxlabel(), drawn.get_supylabel()) == ("eccentricity ε", "damping δ")
