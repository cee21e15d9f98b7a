"""After the warm-ups nothing that the service does has to compile."""

import importlib
import pkgutil

from numba.core.dispatcher import Dispatcher

import rattle_kernels
from rattle_kernels import warm_up, warm_up_analyses

# Of what users call from Python alone: measures of pictures, inverse maps, orbits beyond a graze.
FROM_PYTHON_ALONE = {
    "basin_measures.entropy",
    "basin_measures.integrity",
    "basin_measures.uncertainty_exponent",
    "impact_map.apply",
    "numerics.distance_transform",
    "orbits.orbit_beyond_graze",
}


def kernels():
    """Entry points that are cached on disk, by module and name."""
    found = {}
    for each in pkgutil.walk_packages(rattle_kernels.__path__, "rattle_kernels."):
        module = importlib.import_module(each.name)
        for name, function in vars(module).items():
            if (
                isinstance(function, Dispatcher)
                and function.__module__ == module.__name__
                and function.stats.cache_path
            ):
                found[each.name.removeprefix("rattle_kernels."), name] = function
    return found


def test_every_kernel_of_the_service_is_compiled_by_them():
    warm_up()
    warm_up_analyses()
    cold = {place for place, function in kernels().items() if not function.signatures}
    assert len(kernels()) > 35 and {module for module, _ in cold} <= FROM_PYTHON_ALONE, cold
