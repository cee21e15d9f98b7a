"""How loud a motion is: impacts a period, the largest impact speed, the power of the impacts, and the time in contact.

An impact is an arrival at a wall, on +beta or on -beta, and its speed v_i is that of arrival. In the piecewise linear
model it is a contact, and v_i is the speed of entering it. The power of the impacts is ``sum v_i^2 / (2 m)`` over the
impacts of m forcing periods: the kinetic energy a period that walls turn round. An elastic wall gives all of it back;
one with restitution r keeps the part 1 - r^2.

The time in contact is the part of the time in which teeth touch. In the piecewise linear model these are its contacts.
Impacts of the impacting model take no time, so there it is the part of the time at rest. Bounces slower than 1e-9 of
the scale of speeds count as rest.

A periodic orbit is followed once around, each departure to the next one, so no error grows along it. Chaos is followed
from 512 of the departures in its catalogue. Their scatter gives the error of the means, as it does for the Lyapunov
exponent. The largest speed has no error: it is the largest that was met, and a longer stretch may meet a larger one.
Permanent contact has no impacts, and all of the time in contact.
"""

import math
from typing import NamedTuple

import numpy as np

from rattle_kernels.attractors.attractor import Attractor, AttractorKind
from rattle_kernels.lanes.listening import CONTACT, IMPACTS, LARGEST, SQUARES, TIME, listen, listening_tables
from rattle_kernels.model.domain import check_oscillator
from rattle_kernels.model.oscillator import Oscillator
from rattle_kernels.model.outcome import OUTCOME_RETURNED

# Departures from which chaos is followed, and applications from each. Departures of one trajectory lie 256 impacts or
# more apart in a catalogue: stretches shorter than that share no impact. That number is the same for all of them, so
# they may all begin in one band of chaos in several: a multiple of 2 to 6, 8, 10, 12 and 16 visits each equally often.
_STRETCHES, _APPLICATIONS = 512, 240


class Loudness(NamedTuple):
    """Severity of a motion; NaN where it is not known, as of a motion that is undecided.

    ``impacts_per_period`` counts arrivals on both walls in a forcing period. ``impact_power`` is ``sum v_i^2 / (2 m)``.
    ``time_in_contact`` is a part of the time, from 0 to 1. Standard errors are 0 for a periodic orbit and for permanent
    contact.
    """

    impacts_per_period: float
    largest_impact_speed: float
    impact_power: float
    time_in_contact: float
    impacts_per_period_error: float
    impact_power_error: float
    time_in_contact_error: float


_SILENT = Loudness(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
_NOT_KNOWN = Loudness(*(math.nan,) * len(Loudness._fields))


def _heard(oscillator: Oscillator, t: np.ndarray, v: np.ndarray, applications: int) -> np.ndarray:
    """What is heard from each departure on, without those that fall quiet on the way."""
    heard, outcome = np.zeros((t.size, 5)), np.empty(t.size, np.int8)
    listen(oscillator, listening_tables(oscillator), applications, t.copy(), v.copy(), heard, outcome)
    going: np.ndarray = heard[outcome == OUTCOME_RETURNED]
    return going


def _mean(part: np.ndarray, time: np.ndarray) -> tuple[float, float]:
    """Mean a period, and its standard error from the scatter over independent stretches; NaN for a single one."""
    mean = float(part.sum() / time.sum())
    if part.size < 2:
        return mean, math.nan
    scatter = (part - mean * time) / time.mean()
    return mean, float(scatter.std(ddof=1) / math.sqrt(part.size))


def loudness(oscillator: Oscillator, attractor: Attractor) -> Loudness:
    """How loud a motion is.

    Parameters
    ----------
    oscillator : Oscillator
        Either model.
    attractor : Attractor
        One of its motions, with its points.

    Returns
    -------
    Loudness
        For permanent contact zeros, but for the time in contact. NaN for a motion without points, such as one that is
        undecided. Of a chaotic transient that of its chaos, without what follows.

    Raises
    ------
    OutsideDomain
        If the oscillator's parameters lie outside the domain of the map.

    Examples
    --------
    >>> import math
    >>> orbit = find_attractors(Oscillator(), [0.89829], [3.76991])[1]
    >>> orbit.name, round(loudness(Oscillator(), orbit).largest_impact_speed / (2 * math.pi * 0.6), 9)
    ('P(1,1,0)', 1.0)
    """
    checked = check_oscillator(oscillator)
    if attractor.kind == AttractorKind.PERMANENT_CONTACT:
        return _SILENT
    points = attractor.time.size
    if not points:
        return _NOT_KNOWN
    if attractor.kind == AttractorKind.PERIODIC:
        heard = _heard(checked, attractor.time, attractor.velocity, 1)
        once_around = heard[:, [IMPACTS, SQUARES, CONTACT]].sum(axis=0)
        impacts, squares, contact = (once_around / attractor.forcing_periods).tolist()
        return Loudness(impacts, float(heard[:, LARGEST].max()), 0.5 * squares, contact, 0.0, 0.0, 0.0)
    chosen = np.unique(np.linspace(0, points - 1, _STRETCHES).astype(np.int64))
    heard = _heard(checked, attractor.time[chosen], attractor.velocity[chosen], _APPLICATIONS)
    if not len(heard):
        return _NOT_KNOWN
    impacts, impacts_error = _mean(heard[:, IMPACTS], heard[:, TIME])
    power, power_error = _mean(0.5 * heard[:, SQUARES], heard[:, TIME])
    contact, contact_error = _mean(heard[:, CONTACT], heard[:, TIME])
    largest = float(heard[:, LARGEST].max())
    return Loudness(impacts, largest, power, contact, impacts_error, power_error, contact_error)
