"""Boxes noted on the way are those that the points of chaos hit; who flies past them lands where the map says."""

import numpy as np

from rattle_kernels import Oscillator
from rattle_kernels.attractors import chaotic_boxes
from rattle_kernels.attractors.chaotic_boxes import IMAGES, fly_and_note, keep_boxes, marked_boxes
from rattle_kernels.attractors.chaotic_transient import follow_ensemble
from rattle_kernels.lanes.batch import Rules
from rattle_kernels.lanes.run import LOCK_TOLERANCE, run_lanes
from rattle_kernels.lanes.tables import lane_tables
from rattle_kernels.model.domain import check_domain
from rattle_kernels.model.outcome import Outcome

RATTLING = check_domain(Oscillator())
CHAOTIC = 0.553, 4.703


def _points(number):
    rng = np.random.default_rng(19)
    return rng.random(number), 0.01 + 7.0 * rng.random(number)


def _flown(t, v, legs):
    """Who is kept, where these end, where legs begin, and the boxes; in rows 50 and up of 50 more than there are."""
    rules = Rules(float(IMAGES), lane_tables(RATTLING).capture_bound, LOCK_TOLERANCE)
    t, v, visits = t.copy(), v.copy(), np.full((legs, 2, t.size + 50), np.nan)
    kept, box = fly_and_note(RATTLING, rules, t, v, np.arange(50, t.size + 50), visits)
    return kept, (t[kept], v[kept]), visits[:, :, 50:], box[:, 50:]


def test_who_flies_past_boxes_lands_where_runs_land():
    t, v = _points(150)
    kept, ends, visits, _ = _flown(t, v, 3)
    going = np.arange(t.size)
    for leg in range(3):
        np.testing.assert_array_equal(visits[leg][:, going], [t, v])
        assert np.isnan(np.delete(visits[leg], going, axis=1)).all()
        landed, _ = run_lanes(RATTLING, t, v, IMAGES, shortcuts=True)
        returned = landed.outcome == Outcome.RETURNED
        going, t, v = going[returned], landed.t[returned], landed.v[returned]
    assert 0 < going.size < kept.size  # some are captured
    np.testing.assert_array_equal(np.flatnonzero(kept), going)
    np.testing.assert_array_equal(ends, [t, v])


def test_boxes_are_missing_after_a_capture_or_a_lock():
    t, v = _points(150)
    t[0], v[0] = (
        field[0] for field in run_lanes(RATTLING, np.array([0.89829]), np.array([3.76991]), 4096, shortcuts=True)[0][:2]
    )
    kept, _, _, (box,) = _flown(t, v, 1)
    assert kept[0] and box[0, 0] >= 0 and box[0, -1] < 0  # on P(1,1,0): locked
    assert (box[~kept, -1] < 0).all()
    assert (box[kept, -1] >= 0).any()


def test_boxes_kept_are_those_of_the_points(monkeypatch):
    kept = []
    monkeypatch.setattr(
        "rattle_kernels.attractors.chaotic_transient.keep_boxes",
        lambda *arguments: kept.append(arguments) or keep_boxes(*arguments),
    )
    chaotic_boxes._boxes.cache_clear()
    ensemble = follow_ensemble(RATTLING, *CHAOTIC)
    assert ensemble.chaotic and len(kept) == 1
    points = ensemble.t.tobytes(), ensemble.v.tobytes()
    assert chaotic_boxes._boxes.cache_info().currsize == 1
    noted = marked_boxes(RATTLING, *points)
    assert chaotic_boxes._boxes.cache_info().hits == 1
    chaotic_boxes._boxes.cache_clear()
    flown = marked_boxes(RATTLING, *points)
    assert flown.size > 1000 and noted is not flown
    np.testing.assert_array_equal(noted, flown)


def test_boxes_with_an_image_missing_are_not_kept():
    chaotic_boxes._boxes.cache_clear()
    box = np.full((2, 4, IMAGES), 7)
    box[1, 2, -1] = -1
    box[1, 3] = 1 << 60  # never written, since its trajectory was captured before
    t, v = _points(4)
    keep_boxes(RATTLING, t, v, box, np.arange(3))
    assert chaotic_boxes._boxes.cache_info().currsize == 0
    keep_boxes(RATTLING, t, v, box, np.arange(2))
    assert chaotic_boxes._boxes.cache_info().currsize == 1
    chaotic_boxes._boxes.cache_clear()
