"""Which motion does a rattling gear end in? Ask here.

>>> import rattle
>>> basin = rattle.basin(damping=0.6, eccentricity=0.1, half_backlash=0.6, cells=20, progress=False)
>>> basin.rattle.attractors.name.values.tolist()
['permanent contact', 'P(1,1,0)', 'chaotic']

Times count forcing periods; everything else is nondimensional. `rattle.pictures` has the parts of pictures, and
`rattle_kernels` the mathematics.

``import rattle`` takes a tenth of a second. What loads Numba, Dask, Zarr or Matplotlib is imported by the functions
that need it. The classes of `rattle.names` cannot do so, nor can those that speak to a service. They are loaded when
one is first used: type checkers and editors see them all the same. Packages that stand beside add functions by entry
points of the group `rattle.names`.

Floors, the highest first; each imports from lower ones alone ::

    cli
    remote
    verbs | stores
    arguments | crate
    local | names | pictures | results
    garbage | measured_curve | progress
"""

# ruff: noqa: F403, F405 - the names of `rattle.names` are those of its `__all__`

from importlib import import_module
from importlib.metadata import entry_points, version
from typing import TYPE_CHECKING, Any

from rattle.measured_curve import transmission_error
from rattle.results.cache import cache
from rattle.results.opening import open
from rattle.stores import check, export
from rattle.verbs import basin, bifurcation, compute, grazing_curve, manifolds, orbits, sweep, trajectory
from worker.progress import Progress

if TYPE_CHECKING:
    from rattle import pictures as pictures
    from rattle.names import *
    from rattle.remote.failure import ServiceFailed
    from rattle.remote.job import RemoteJob
    from rattle.remote.service import Service, connect
else:
    _REMOTE = {"RemoteJob": "job", "Service": "service", "ServiceFailed": "failure", "connect": "service"}

    def __getattr__(name: str) -> Any:
        if name == "pictures":
            return import_module("rattle.pictures")
        beside = [] if name in __all__ else list(entry_points(group="rattle.names", name=name))
        if name not in __all__ and not beside:
            raise AttributeError(f"module 'rattle' has no attribute {name!r}; it has {', '.join(__all__)}")
        module = f"rattle.remote.{_REMOTE[name]}" if name in _REMOTE else "rattle.names"
        found = globals()[name] = beside[0].load() if beside else getattr(import_module(module), name)
        return found


__version__ = version("gear-rattle")
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
    "Progress",
    "RemoteJob",
    "Sample",
    "Service",
    "ServiceFailed",
    "Spacing",
    "StoreConflict",
    "StoreFailed",
    "SweepJob",
    "SweptParameter",
    "TransmissionError",
    "WorkerError",
    "basin",
    "bifurcation",
    "cache",
    "check",
    "compute",
    "connect",
    "eccentric_gears",
    "estimate",
    "export",
    "grazing_curve",
    "manifolds",
    "open",
    "orbits",
    "sweep",
    "torque_ripple",
    "trajectory",
    "transmission_error",
]


def __dir__() -> list[str]:
    return [*__all__, "__version__", "pictures"]
