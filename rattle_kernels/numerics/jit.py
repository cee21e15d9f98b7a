"""How every kernel is compiled, said once.

Two kinds of compiled function: a *step* is a scalar piece that other kernels call (compiled into its caller, never
cached alone); a *kernel* is an entry point called from Python (cached on disk, releases the GIL, serial: tiles make the
parallelism).

Numba's disk cache looks only at the file of the cached function: when a step in another module changes, the old machine
code would be served. So the cache folder carries a hash of all sources of this package, and of the versions that
compile them.
"""

import contextlib
import hashlib
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core import config, event

# Contraction to FMA only. Reassociation and the no-NaN flags would blur the small differences that decide grazing.
_CAREFUL = {"contract"}
# The lanes divide by what they have just tested; -0 and +0 need not be told apart there.
_LANES = {"contract", "nsz", "arcp"}


def _sources_hash() -> str:
    package = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for version in (numba.__version__, llvmlite.__version__, np.__version__):
        digest.update(version.encode())
    for path in sorted(package.rglob("*.py")):
        digest.update(path.relative_to(package).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder() -> Path:
    """Folder of the compiled kernels of exactly these sources.

    Returns
    -------
    Path
        Below ``NUMBA_CACHE_DIR`` where that is set, else below the user's cache folder.
    """
    root = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(root) / "gear-rattle" / f"kernels-{_sources_hash()}"


_CACHE_FOLDER = str(cache_folder())


KERNELS: list[Any] = []
"""Every kernel of the modules that are loaded."""


class _Misses(event.Listener):
    def __init__(self, report: Callable[[], None]) -> None:
        self._report = report

    def on_start(self, compiling: event.Event) -> None:
        # Steps are compiled within their kernels.
        if compiling.data["dispatcher"] in KERNELS:
            self._report()

    def on_end(self, compiling: event.Event) -> None:
        pass


@contextlib.contextmanager
def watch_compiling(report: Callable[[], None]) -> Iterator[None]:
    """Call a function before each kernel that is compiled while the context lasts, and not loaded from the disk cache.

    Parameters
    ----------
    report : callable
        Called in the thread that compiles.
    """
    with event.install_listener("numba:compile", _Misses(report)):
        yield


def step(function: Callable[..., Any]) -> Any:
    """Compile a scalar piece of mathematics that kernels call."""
    return numba.njit(nogil=True, error_model="numpy", fastmath=_CAREFUL)(function)


def lane_step(function: Callable[..., Any]) -> Any:
    """Compile a branch-free piece that LLVM inlines into a loop over lanes and vectorises."""
    return numba.njit(nogil=True, error_model="numpy", fastmath=_LANES)(function)


def kernel(function: Callable[..., Any]) -> Any:
    """Compile an entry point called from Python, cached on disk."""
    return _cached(function, _CAREFUL)


def lane_kernel(function: Callable[..., Any]) -> Any:
    """Compile an entry point that runs in lanes, cached on disk."""
    return _cached(function, _LANES)


def _cached(function: Callable[..., Any], fastmath: set[str]) -> Any:
    # Numba reads its cache folder when a function is decorated; other users of Numba in this process keep theirs.
    elsewhere = config.CACHE_DIR
    config.CACHE_DIR = _CACHE_FOLDER
    try:
        compiled = numba.njit(nogil=True, error_model="numpy", fastmath=fastmath, cache=True)(function)
    finally:
        config.CACHE_DIR = elsewhere
    KERNELS.append(compiled)
    return compiled
