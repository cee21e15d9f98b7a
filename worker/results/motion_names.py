"""Names of the motions of a bifurcation diagram, at each value: a branch keeps neither period nor contacts."""

import json
from functools import lru_cache

import numpy as np
import pandas as pd
import xarray as xr

from rattle_kernels import Direction, Oscillator, Outcome, time_history
from rattle_kernels.model.flight import fall_speed
from rattle_kernels.orbits.periodic_orbit import find_periodic_orbit, orbit_name
from worker.jobs.bifurcation_job import BifurcationJob
from worker.stores.layout import Columns

NO_PERIOD = "no period seen"
"""Chaos, a period of more impacts than half of those kept, or a motion that has not settled yet."""
MOST_NAMED = 10_000
"""Most motions that are named: each is followed once around, which takes some seconds for all of them."""
_QUIET = "permanent contact"
_CONTACTS_A_DEPARTURE = 64


# A picture, its formats and tables name the same motions, and a diagram that grows those of before. Some 10 MB.
@lru_cache(maxsize=2 * MOST_NAMED)
def itinerary(oscillator: Oscillator, t: float, v: float, impact_period: int) -> str:
    """Name P(m,n+,n-) of a motion that repeats itself, from one of its departures and its impact period."""
    if oscillator.is_loose:  # a history has the bounces of a chatter one by one
        orbit = find_periodic_orbit(oscillator, t, v, impact_period, fall_speed(oscillator))
        return NO_PERIOD if orbit is None else orbit.name
    beta = oscillator.half_backlash
    most = _CONTACTS_A_DEPARTURE * impact_period
    history = time_history(
        oscillator, t, beta, -v, departures=impact_period, periods=float(most), samples_per_period=1, most_contacts=most
    )
    contacts = history.contacts
    lower = int(np.count_nonzero((contacts.wall < 0) & (contacts.direction != Direction.OUT)))
    around = contacts.time[history.departures[impact_period - 1]] - t
    return orbit_name(round(float(around)), impact_period, lower)


def _name(job: BifurcationJob, value: float, outcome: int, period: int, t: float, v: float) -> str:
    if outcome == Outcome.PERMANENT_CONTACT:
        return _QUIET
    if outcome != Outcome.RETURNED:
        return ""
    return itinerary(job.oscillator_at(value), t, v, period) if period > 0 else NO_PERIOD


def motion_names(job: BifurcationJob, columns: Columns) -> list[str]:
    """Names of the motions of a diagram, by visit and seed.

    Parameters
    ----------
    job : BifurcationJob
    columns : mapping of str to ndarray
        Of its store.

    Returns
    -------
    list of str
        Empty where nothing is computed, or where the motion could not be followed.
    """
    t, v = columns["time"][..., -1].ravel(), columns["velocity"][..., -1].ravel()
    values = np.repeat(columns[job.vary.parameter], columns["outcome"].shape[1])
    arrays = values, columns["outcome"].ravel(), columns["impact_period"].ravel(), t, v
    return [_name(job, *row) for row in zip(*(array.tolist() for array in arrays), strict=True)]


def add_motion_names(dataset: xr.Dataset, table: pd.DataFrame) -> pd.DataFrame:
    """The table of impact periods of a diagram with a column of names, unless there are too many.

    Parameters
    ----------
    dataset : xarray.Dataset
        A diagram, of `worker.results.opening.open_store`.
    table : pandas.DataFrame
        Its table ``impact_period``.

    Returns
    -------
    pandas.DataFrame
        Empty names are those of values that are not computed, or at which the motion could not be followed.
    """
    if len(table) > MOST_NAMED:
        return table
    job = BifurcationJob.from_request(json.loads(dataset.attrs["request"]))
    used = (job.vary.parameter, "time", "velocity", "outcome", "impact_period")
    return table.assign(name=motion_names(job, {name: dataset[name].values for name in used}))
