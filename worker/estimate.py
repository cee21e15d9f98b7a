"""How long a job takes and how many bytes its store has, before it begins.

The seconds come from the applications of P that a job asks for and from the speed of this machine, which is measured
once in a process, in a tenth of a second. Cells that are captured or locked end early, so most jobs take less. What
every job and every basin takes besides is added: it is most of what a small one takes. So is what a package adds.
"""

import math
import time
from typing import NamedTuple

import numpy as np

from rattle_kernels import Oscillator, OutsideDomain, check_domain, next_impacts
from worker.additions import asked_of
from worker.jobs.basin_job import BasinJob
from worker.jobs.job import Job

# Of each model, the machine whose speed stands for all.
_MACHINES = {
    "impacting": Oscillator(),
    "stiff": Oscillator(stiffness=1e4),
    "loose": Oscillator(eccentricity=0.4, restitution=0.7),
    "loose and stiff": Oscillator(eccentricity=0.4, stiffness=1e4),
}
# Departures, and how often P is applied to each: cells fly together, 64 at a time; analyses follow one at a time.
_TOGETHER, _ALONE = (512, 500), (1, 20_000)


# Seconds that a job takes to begin and to end, with its store and its tasks; and that a core takes for the catalogue,
# the groups and the arrays of one basin. Measured with basins and sweeps of 20 x 20 cells, on a busy machine.
_OF_A_JOB, _OF_A_BASIN = 0.3, 0.2
# Applications, by the measured speed, that labels and the naming of a landing point take. Measured with k = 1, where
# each cell has a landing point of its own: 200 to 230, 130 to 2,000 (the stiffer, the more), 34 and 160.
_OF_A_LANDING = {"impacting": 300, "stiff": 2500, "loose": 100, "loose and stiff": 300}
# With k applications cells share landing points: a million cells have some 20,000 with k = 1499.
_LEAST_SHARE_LANDING_ALONE = 0.03


class Estimate(NamedTuple):
    """What a job asks for.

    Parameters
    ----------
    seconds : float
        At most, on so many cores as were given.
    bytes : int
        Of its store, before compression.
    """

    seconds: float
    bytes: int

    def __str__(self) -> str:
        return f"up to some {_in_words(self.seconds)}, and {_bytes_in_words(self.bytes)} before compression"


# Applications in a second where none is measured yet, of many together or of one alone: a third of what machines do.
_USUAL = {True: 1e7, False: 3e5}
_USUAL_LOOSE = {"loose": {True: 1e6, False: 1e5}, "loose and stiff": {True: 1.5e5, False: 5e4}}
_measured: dict[tuple[str, bool], float] = {}


def measured_speed(model: str, together: bool) -> float:
    """Applications of P in a second on one core, measured when it is first needed.

    Parameters
    ----------
    model : str
        ``impacting`` or ``stiff``; ``loose`` or ``loose and stiff`` beyond the bound of Eq. (8).
    together : bool
        Of many trajectories together, as for cells, or of one alone, as in analyses.

    Returns
    -------
    float
    """
    if (model, together) in _measured:
        return _measured[model, together]
    oscillator = _MACHINES[model]
    departures, applications = _TOGETHER if together else _ALONE
    # About the paper's chaotic attractor, where a motion takes all applications.
    t, v = 0.55 + np.arange(departures) / (10.0 * departures), np.full(departures, 4.67)
    next_impacts(oscillator, t[:1], v[:1], applications)  # loads the kernels of short and long runs, and makes tables
    begun = time.perf_counter()
    next_impacts(oscillator, t, v, applications)
    _measured[model, together] = departures * applications / (time.perf_counter() - begun)
    return _measured[model, together]


def _model_of(job: Job) -> str:
    """Of the slowest machine of a job."""
    impacting = math.isinf(job.oscillator.stiffness)
    try:
        job.check_oscillators(check_domain)
    except OutsideDomain:
        return "loose" if impacting else "loose and stiff"
    return "impacting" if impacting else "stiff"


def estimate(job: Job, cores: int = 1, *, measuring: bool = True) -> Estimate:
    """Estimate the time and the store of a job.

    Parameters
    ----------
    job : Job
    cores : int
        Cores that compute at the same time.
    measuring : bool
        Whether to measure the speed where that has not been done. It takes a minute where kernels must be compiled.

    Returns
    -------
    Estimate

    Examples
    --------
    >>> from worker.jobs.basin_job import BasinJob
    >>> estimate(BasinJob(iterations=1)).bytes
    38000000
    """
    model = _model_of(job)
    shared = {True: job.impacts_together, False: job.impacts - job.impacts_together}
    flying = sum(impacts / _speed(model, together, measuring) for together, impacts in shared.items() if impacts)
    basins = 0
    if isinstance(job, BasinJob):
        basins = job.basins
        landings = job.cell_count * max(1.0 / job.iterations, _LEAST_SHARE_LANDING_ALONE)
        flying += landings * _OF_A_LANDING[model] / _speed(model, True, measuring)
    at_once = max(min(basins, cores), 1)
    added = [each.cost(job) for each in asked_of(job)]
    seconds = _OF_A_JOB + basins * _OF_A_BASIN / at_once + flying / min(cores, job.tasks_at_once)
    seconds += sum(each.seconds for each in added) / cores
    return Estimate(seconds, job.bytes + sum(each.bytes for each in added))


def _speed(model: str, together: bool, measuring: bool) -> float:
    if measuring or (model, together) in _measured:
        return measured_speed(model, together)
    return _USUAL_LOOSE.get(model, _USUAL)[together]


def _in_words(seconds: float) -> str:
    for size, name in ((86400.0, "days"), (3600.0, "hours"), (60.0, "minutes")):
        if seconds >= size:
            return f"{seconds / size:.1f} {name}"
    return f"{math.ceil(seconds)} s"


def _bytes_in_words(count: int) -> str:
    for size, name in ((10**12, "TB"), (10**9, "GB"), (10**6, "MB")):
        if count >= size:
            return f"{count / size:.1f} {name}"
    return f"{count / 1000:.0f} kB"
