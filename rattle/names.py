"""The public names whose modules load Numba: `rattle` has them as well, and takes them from here on first use."""

from rattle_kernels import Oscillator, OutsideDomain, TransmissionError, eccentric_gears, torque_ripple
from worker.errors import InvalidJob, JobCancelled, NotFound, StoreConflict, StoreFailed, WorkerError
from worker.estimate import estimate
from worker.gear_pair import GearPair
from worker.jobs.basin_job import BasinJob, SweepJob
from worker.jobs.bifurcation_job import BifurcationJob
from worker.jobs.grazing_curve_job import GrazingCurveJob
from worker.jobs.manifold_job import ManifoldJob
from worker.jobs.orbits_job import OrbitsJob
from worker.jobs.sample import Sample
from worker.jobs.swept_parameter import Spacing, SweptParameter

__all__ = [
    "BasinJob",
    "BifurcationJob",
    "GearPair",
    "GrazingCurveJob",
    "InvalidJob",
    "JobCancelled",
    "ManifoldJob",
    "NotFound",
    "OrbitsJob",
    "Oscillator",
    "OutsideDomain",
    "Sample",
    "Spacing",
    "StoreConflict",
    "StoreFailed",
    "SweepJob",
    "SweptParameter",
    "TransmissionError",
    "WorkerError",
    "eccentric_gears",
    "estimate",
    "torque_ripple",
]
