"""Many applications of P to many points: 64 trajectories fly side by side.

All points begin with a short run. Those that need more applications go on with a long one. Each lane's arithmetic is
the same whichever lane it is and whatever its neighbours do, so a result depends on nothing but its starting point.
"""

import numpy as np

from rattle_kernels.impact_map.apply import Impacts
from rattle_kernels.lanes.batch import Batch, LaneRun, Rules
from rattle_kernels.lanes.long_run import run_long
from rattle_kernels.lanes.short_run import LONGEST_SHORT_RUN, run_short
from rattle_kernels.lanes.tables import LooseTables, lane_tables
from rattle_kernels.lanes.traps import NO_TRAPS, LaneTraps
from rattle_kernels.model.departures import check_departures
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_RETURNED
from rattle_kernels.numerics.pausing import Pause, never_stopped

LOCK_TOLERANCE = 1e-13
"""Closer than this to a state before, a trajectory is locked: in periods and largest grazing speeds."""


def run_lanes(
    oscillator: Oscillator,
    t: np.ndarray,
    v: np.ndarray,
    applications: int,
    *,
    shortcuts: bool,
    traps: LaneTraps = NO_TRAPS,
    pause: Pause = never_stopped,
) -> tuple[Impacts, LaneRun]:
    """Apply P many times to many points.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    t, v : ndarray of float64, shape (n,)
        Phases and speeds of departures from +beta. Not changed.
    applications : int
        How often P is applied, at least 1.
    shortcuts : bool
        Whether captured points end early (outcome PERMANENT_CONTACT, state at capture), locked ones skip whole periods,
        and those of a loose gear that chatter to rest depart next at their release. With shortcuts ``lower_impacts``
        counts contacts of the applications done, without them all contacts.
    traps : LaneTraps
        A point inside a trap lands on its orbit at once.
    pause : callable
        Called several times a second; an exception raised there ends the work.

    Returns
    -------
    Impacts, LaneRun
        Landing points, and what it took.
    """
    tables = lane_tables(oscillator)
    if isinstance(tables, LooseTables) and not shortcuts:
        tables = tables._replace(upper_jumps_below=0.0)
    capture_bound, lock_tolerance = (tables.capture_bound, LOCK_TOLERANCE) if shortcuts else (0.0, -1.0)
    begins = Rules(float(min(applications, LONGEST_SHORT_RUN)), capture_bound, lock_tolerance)
    batch = Batch(np.empty(t.size), np.empty(t.size), np.empty(t.size, np.int8), np.empty(t.size, np.int64))
    # Kernels are compiled for arrays that are contiguous and may be written. Others are copied.
    departures = np.require(t, requirements=["C", "W"]), np.require(v, requirements=["C", "W"])
    run = run_short(oscillator, tables, begins, departures, batch, pause)
    if applications > LONGEST_SHORT_RUN:
        going = np.flatnonzero(batch.outcome == OUTCOME_RETURNED)
        rest = Batch(*(field[going] for field in batch))
        rules = begins._replace(applications=float(applications))
        run = LaneRun(*map(sum, zip(run, run_long(oscillator, tables, traps, rules, rest, pause), strict=True)))
        for field, later in zip(batch, rest, strict=True):
            field[going] = later
    return Impacts(batch.t, batch.v, batch.lower_impacts, batch.outcome), run


def next_impacts(
    oscillator: Oscillator,
    t: np.typing.ArrayLike,
    v: np.typing.ArrayLike,
    applications: int = 1,
    *,
    shortcuts: bool = False,
) -> Impacts:
    """Apply P to every point.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    t, v : array_like, broadcast together
        Phase (forcing periods, any finite value) and speed of departures from +beta. Both are NaN where a motion has
        come to rest, and stay NaN.
    applications : int
        How often P is applied.
    shortcuts : bool
        Whether a motion that ever lower bounces have captured ends early (outcome PERMANENT_CONTACT, state at capture),
        and one that is locked to a periodic orbit skips whole turns. Long motions then take a fraction of the time.
        Beyond the bound of Eq. (8) a motion that comes to rest departs next at its release, with a speed of 1e-300: all
        bounces that lead to a rest are one application.

    Returns
    -------
    Impacts
        ``lower_impacts`` counts the contacts with -beta of all applications; with shortcuts, of those that were done.

    Raises
    ------
    OutsideDomain
        Where the oscillator's parameters lie outside the domain of the map.
    ValueError
        Where ``applications`` is below 1, or a point is no departure: not finite, or without a positive speed.

    Examples
    --------
    >>> impacts = next_impacts(Oscillator(damping=0.6, eccentricity=0.1, half_backlash=0.6), [0.25, 0.5], [1.0, 6.0])
    >>> impacts.lower_impacts
    array([0, 1])
    """
    checked = check_oscillator(oscillator)
    if applications < 1:
        raise ValueError(f"applications must be at least 1, not {applications}")
    points = check_departures(t, v, ended=True)
    shape = np.broadcast_shapes(points[0].shape, points[1].shape)
    # An array of this shape stays what it is: one that was broadcast cannot be written, and would be copied.
    phase, speed = (each if each.shape == shape else np.broadcast_to(each, shape) for each in points)
    impacts, _ = run_lanes(checked, phase.ravel(), speed.ravel(), applications, shortcuts=shortcuts)
    return Impacts(*(field.reshape(shape) for field in impacts))
