"""After the warm-ups nothing that the service does has to compile."""

import importlib
import pkgutil

from numba.core.dispatcher import Dispatcher

import rattle_kernels
from rattle_kernels import warm_up, warm_up_analyses

# Of what users call from Python alone: measures of pictures, inverse maps, orbits beyond a graze.
FROM_PYTHON_ALONE = {"basin_entropy", "basin_integrity", "distance_transform", "impact_map", "orbit_beyond_graze"}
FROM_PYTHON_ALONE |= {"uncertainty_exponent"}


def kernels():
    """Entry points that are cached on disk, by module and name."""
    found = {}
    for each in pkgutil.iter_modules(rattle_kernels.__path__):
        module = importlib.import_module(f"rattle_kernels.{each.name}")
        for name, function in vars(module).items():
            if (
                isinstance(function, Dispatcher)
                and function.__module__ == module.__name__
                and function.stats.cache_path
            ):
                found[each.name, name] = function
    return found


def test_every_kernel_of_the_service_is_compiled_by_them():
    warm_up()
    warm_up_analyses()
    cold = {place for place, function in kernels().items() if not function.signatures}
    assert len(kernels()) > 35 and {module for module, _ in cold} <= FROM_PYTHON_ALONE, cold
