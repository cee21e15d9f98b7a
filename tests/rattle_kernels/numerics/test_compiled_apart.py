"""Kernels that the disk cache lacks are compiled in another process, which a pause can stop."""

import json
import os
import subprocess
import sys

_MULTIPLY = """
import json, sys
from rattle_kernels.numerics.compiled_apart import compiled_apart
from rattle_kernels.numerics.fused_multiply_add import _multiply_and_add as kernel
from rattle_kernels.numerics.jit import watch_compiling

sys.executable = {executable!r}
pauses, told = [], []

def pause():
    pauses.append(1)
    if {stop}:
        raise KeyboardInterrupt

with watch_compiling(lambda: told.append(1)):
    try:
        with compiled_apart(pause):
            value = kernel(2.0, 3.0, 4.0)
    except KeyboardInterrupt:
        value = None
stats = kernel.stats
hits, misses = (sum(each.values()) for each in (stats.cache_hits, stats.cache_misses))
print(json.dumps([value, hits, misses, len(told), len(pauses) > 0]))
"""


def _run(folder, stop=False, executable=sys.executable):
    """Value of a kernel, how often it was loaded and compiled here, how often that was told, if there were pauses."""
    command = [sys.executable, "-c", _MULTIPLY.format(stop=stop, executable=executable)]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(folder)}
    ran = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
    return json.loads(ran.stdout)


def test_a_kernel_is_compiled_there_once_and_loaded_here(tmp_path):
    assert _run(tmp_path) == [10.0, 1, 0, 1, True]
    assert _run(tmp_path) == [10.0, 1, 0, 0, False]


def test_a_pause_that_raises_stops_it(tmp_path):
    assert _run(tmp_path, stop=True) == [None, 0, 0, 1, True]
    assert not list(tmp_path.rglob("*.nbi"))


def test_a_kernel_is_compiled_here_where_there_cannot_be_another_process(tmp_path):
    assert _run(tmp_path, executable="false")[:3] == [10.0, 0, 1]
