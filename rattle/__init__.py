"""Which motion does a rattling gear end in? Ask here.

>>> import rattle
>>> basin = rattle.basin(damping=0.6, eccentricity=0.1, half_backlash=0.6, cells=20, progress=False)
>>> basin.rattle.attractors.name.values.tolist()
['permanent contact', 'P(1,1,0)', 'chaotic']

Times count forcing periods; everything else is nondimensional. `rattle.pictures` has the parts of pictures, and
`rattle_kernels` the mathematics. The names of this module are loaded when they are first used: ``import rattle`` itself
takes no time.
"""

from importlib import import_module
from typing import Any

from rattle.loading import without_collections
from rattle.processor import use_whole_registers

_HOMES = {
    "rattle.verbs": ("basin", "sweep", "bifurcation", "orbits", "manifolds", "grazing_curve", "trajectory", "compute"),
    "rattle.stores.checking": ("check",),
    "rattle.stores.exporting": ("export",),
    "rattle.stores.verifying": ("verify",),
    "rattle.results.opening": ("open",),
    "rattle.remote.verbs": ("connect", "Service"),
    "rattle.remote.job": ("RemoteJob",),
    "rattle.remote.failure": ("ServiceFailed",),
    "rattle.results.kept": ("cache",),
    "rattle.measured_curve": ("transmission_error",),
    "rattle_kernels": ("Oscillator", "OutsideDomain", "TransmissionError", "eccentric_gears", "torque_ripple"),
    "worker.estimate": ("estimate",),
    "worker.errors": ("WorkerError", "InvalidJob", "NotFound", "StoreConflict", "StoreFailed", "JobCancelled"),
    "worker.progress": ("Progress",),
    "worker.jobs.basin_job": ("BasinJob", "SweepJob"),
    "worker.jobs.swept_parameter": ("SweptParameter", "Spacing"),
    "worker.jobs.sample": ("Sample",),
    "worker.jobs.bifurcation_job": ("BifurcationJob",),
    "worker.jobs.orbits_job": ("OrbitsJob",),
    "worker.jobs.manifold_job": ("ManifoldJob",),
    "worker.jobs.grazing_curve_job": ("GrazingCurveJob",),
}
_MODULES = ("pictures",)
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = sorted(_HOME_OF)  # noqa: PLE0605 - the names of the table


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("gear-rattle")
    if name in _MODULES:
        return import_module(f"rattle.{name}")
    if name not in _HOME_OF:
        raise AttributeError(f"module 'rattle' has no attribute {name!r}; it has {', '.join(__all__)}")
    use_whole_registers()
    with without_collections():
        found = getattr(import_module(_HOME_OF[name]), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return [*__all__, *_MODULES, "__version__"]
