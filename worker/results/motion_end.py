"""What one followed motion does in the end: said of its own history, not of a cell near its departure."""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels import Attractor, Direction, Oscillator, TimeHistory, next_impacts
from rattle_kernels.attractors.attractor import PERMANENT_CONTACT_ATTRACTOR
from rattle_kernels.attractors.settled_orbit import attractor_of, settled_orbit
from rattle_kernels.impact_map.loose_map import RELEASED
from rattle_kernels.orbits.periodic_orbit import orbit_name
from worker.errors import InvalidJob
from worker.jobs.trajectory_request import TrajectoryRequest

FOLLOWED_PERIODS = 1000
"""How long a motion is followed before it counts as one that still rattles."""

# A motion is on an orbit once all its departures are this close to the orbit's points: in forcing periods and in speed.
_CLOSE = np.array([1e-3, 1e-3])
# It nearly repeats itself while it comes this close to where it was.
_NEAR = np.array([1e-3, 5e-3])
_SURE = 3
# It has left what it nearly repeated at first once it is this many times as far.
_FAR = 50.0
_LONGEST_REPEATED = 24


class Repeated(NamedTuple):
    """An itinerary that a motion nearly repeats at first, as beside a saddle, and how many forcing periods long."""

    name: str
    periods: float


class MotionEnd(NamedTuple):
    """What a motion has done, as far as it was followed.

    ``settled`` is the attractor that it has come to, None while it still rattles without one; ``periods`` and
    ``impacts`` are counted from its start until it has settled, or else until it was left.
    """

    settled: Attractor | None
    periods: float
    impacts: int
    first: Repeated | None


def _apart(one: np.ndarray, other: np.ndarray, close: np.ndarray) -> np.ndarray:
    """Distances of departures (t, v), in units of what counts as close."""
    apart = one - other
    apart[..., 0] -= np.rint(apart[..., 0])
    return np.abs(apart / close).max(axis=-1)


def _first_on(departures: np.ndarray, orbit: Attractor) -> int | None:
    """Number of the departure from which all lie on an orbit; None if the last few do not."""
    points = np.column_stack([orbit.time, orbit.velocity])
    on = np.array([_apart(points, each, _CLOSE).min() < 1.0 for each in departures])
    off = np.flatnonzero(~on)
    first = int(off[-1]) + 1 if off.size else 0
    return first if len(departures) - first >= max(_SURE, len(points)) else None


def _repeated_at_first(departures: np.ndarray, lower: np.ndarray) -> Repeated | None:
    """What the first departures nearly repeat for three turns and later ones leave; `lower` are times of -beta."""
    for period in range(1, min(_LONGEST_REPEATED, (len(departures) - 1) // _SURE) + 1):
        away = _apart(departures, departures[np.arange(len(departures)) % period], _NEAR)
        off = np.flatnonzero(away >= 1.0)
        if off.size and off[0] >= _SURE * period and away.max() > _FAR:
            t = departures[:, 0]
            contacts = np.count_nonzero((lower > t[0]) & (lower < t[period]))
            name = orbit_name(round(t[period] - t[0]), period, int(contacts))
            return Repeated(name, float(t[off[0] - 1] - t[0]))
        if off.size == 0:
            return None
    return None


def _without_chatter(oscillator: Oscillator, departures: np.ndarray, released: np.ndarray) -> np.ndarray:
    """Departures of a loose gear from which P leads to each other: from the impact before a chatter to its release."""
    departures[:, 1] = np.maximum(departures[:, 1], RELEASED)
    chatters = next_impacts(oscillator, *departures[:-1].T, shortcuts=True).v == RELEASED
    return departures[np.append(True, released[1:] | ~chatters)]


def motion_end(oscillator: Oscillator, history: TimeHistory, start: tuple[float, float]) -> MotionEnd:
    """What a motion from +beta does in the end, by its history alone.

    Parameters
    ----------
    oscillator : Oscillator
        Checked by the caller.
    history : TimeHistory
        Of the motion, from its departure on.
    start : tuple of float
        Phase and speed of the departure.

    Returns
    -------
    MotionEnd
        It has settled if contact has become permanent, or if its last departures lie within 0.001 of an attracting
        periodic orbit that they approach, in forcing periods and in speed.

    Examples
    --------
    >>> from rattle_kernels import time_history
    >>> oscillator = Oscillator()
    >>> history = time_history(oscillator, 0.3, oscillator.half_backlash, -4.0, periods=100, samples_per_period=1)
    >>> end = motion_end(oscillator, history, (0.3, 4.0))
    >>> end.settled is not None
    True
    """
    contacts = history.contacts
    begun = contacts.time[contacts.direction != Direction.OUT]
    # The speed of an impact is that of its arrival.
    speed = np.where(contacts.direction == Direction.IMPACT, oscillator.restitution, 1.0) * contacts.speed
    departures = np.vstack([start, np.column_stack([contacts.time, speed])[history.departures]])
    if oscillator.is_loose and math.isinf(oscillator.stiffness):
        released = contacts.direction[history.departures] == Direction.OUT
        departures = _without_chatter(oscillator, departures, np.append(False, released))
    lower = contacts.time[(contacts.wall == -1) & (contacts.direction != Direction.OUT)]
    settled: Attractor | None = None
    until = float(history.time[-1])
    if np.isfinite(history.permanent_from):
        settled, until = PERMANENT_CONTACT_ATTRACTOR, history.permanent_from
    else:
        orbit = settled_orbit(oscillator, departures[-1, 0] % 1.0, departures[-1, 1])
        first = None if orbit is None else _first_on(departures, attractor_of(orbit))
        if orbit is not None and first is not None:
            settled, until = attractor_of(orbit), float(departures[first, 0])
    impacts = int(np.count_nonzero(begun <= until))
    return MotionEnd(settled, until - start[0], impacts, _repeated_at_first(departures, lower))


def end_of(request: TrajectoryRequest, most_contacts: int) -> MotionEnd:
    """What the motion of a request does in the end, followed further than it is shown.

    Parameters
    ----------
    request : TrajectoryRequest
        Of a departure from +beta.
    most_contacts : int
        No more contacts are followed.

    Returns
    -------
    MotionEnd

    Raises
    ------
    OutsideDomain, InvalidJob
        Naming what is wrong.
    """
    if request.start.displacement is not None:
        raise InvalidJob("the end is told of departures from +beta only: leave the displacement out", ("start",))
    longer = request.model_copy(update={"periods": FOLLOWED_PERIODS, "samples_per_period": 1})
    start = request.start.time, request.start.velocity
    return motion_end(request.oscillator.value, longer.follow(most_contacts), start)
