"""How every kernel is compiled.

There are two kinds of compiled function. An *inlined* function is a piece that kernels call: it is compiled with its
caller and never cached alone. A *kernel* is an entry point called from Python: it is cached on disk and releases
the GIL. Kernels are serial; tiles make the parallelism.

Numba's disk cache checks only the file of the cached function. If an inlined function in another module changed, the
old machine code would be served. So the name of the cache folder contains a hash of all sources of this package, of the
versions that compile them, and of the options that change the machine code. Kernels of a package beside are keyed by
its sources as well.
"""

import contextlib
import hashlib
import os
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from functools import cache, wraps
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite
import numba
import numpy as np
from numba import types
from numba.core import config, event
from numba.core.dispatcher import Dispatcher
from numba.extending import overload

from rattle_kernels.numerics.whole_registers import compiler

# Contraction to FMA only. Reassociation and the no-NaN flags would blur the small differences that decide grazing.
_CAREFUL = {"contract"}
# The lanes divide by what they have just tested, and they need not distinguish -0 from +0.
_LANES = {"contract", "nsz", "arcp"}
# A function that lacks an option takes it from whatever is being compiled when it is first called. So each has all.
_AS_WRITTEN: dict[str, Any] = {
    "nogil": True, "error_model": "numpy", "fastmath": False, "forceinline": False, "pipeline_class": compiler(),
}  # fmt: skip
_INLINED = _AS_WRITTEN | {"fastmath": _CAREFUL}


_PACKAGE = Path(__file__).parents[1]
_beside: list[Path] = []


def key_by(folder: str) -> None:
    """Key kernels of a package beside by the sources in a folder, too: what they inline lies there or in this package.

    Parameters
    ----------
    folder : str
        Named by the package before it defines any.
    """
    _beside.append(Path(folder))


@cache
def _sources_hash(*folders: Path) -> str:
    digest = hashlib.sha256()
    for version in (numba.__version__, llvmlite.__version__, np.__version__):
        digest.update(version.encode())
    digest.update(b"bounds checked" if config.BOUNDSCHECK else b"")
    for folder in folders:
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.relative_to(folder).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder(source: str = __file__) -> Path:
    """Folder of the compiled kernels of exactly these sources.

    Parameters
    ----------
    source : str
        File that defines a kernel. One of no package, such as a test's, may inline what any package beside has.

    Returns
    -------
    Path
        Below ``NUMBA_CACHE_DIR`` where that is set, else below the user's cache folder.
    """
    root = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    own = [folder for folder in (_PACKAGE, *_beside) if Path(source).is_relative_to(folder)] or _beside
    folders = dict.fromkeys((_PACKAGE, *own))
    return Path(root) / "gear-rattle" / f"kernels-{_sources_hash(*folders)}"


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


@contextlib.contextmanager
def timing_compilation() -> Iterator[Callable[[], float]]:
    """Tell how many seconds this process has spent on compiling while the context lasts.

    Yields
    ------
    callable
        Returns the seconds so far, without a compilation under way.
    """
    timer = event.TimingListener()
    with event.install_listener("numba:compile", timer):
        yield lambda: timer.duration if timer.done else 0.0


def inlined(function: Callable[..., Any]) -> Any:
    """Compile a scalar piece of mathematics that kernels call."""
    return numba.njit(**_INLINED)(function)


def always_inlined(function: Callable[..., Any]) -> Any:
    """Compile a loop over lanes into each of its callers, however long it is.

    LLVM leaves a long function apart. A process that compiles a kernel then has the function twice: by itself, compiled
    for arrays that may overlap, and with the kernel. The linker takes the first, and the kernel ran at half the speed
    that it had when it was loaded from the disk. Inlined, loops also know the buffer, and are a fifth faster.

    For loops alone. The scalar pieces of the careful path are left to LLVM: inlined everywhere, they fuse other
    products, and last digits change.
    """
    return numba.njit(**_INLINED | {"forceinline": True})(function)


def summed_over_tuple(function: Callable[..., Any]) -> Any:
    """Compile ``function(terms, total, place)``, which adds every term of a tuple to a total.

    Of an empty tuple the total is given back untouched: what calls it keeps its machine code. Many terms are an array
    of records (`record_type`), and one machine code serves any number of them.
    """

    def untouched(terms: Any, total: Any, place: Any) -> Any:
        return total

    def choose(terms: Any, total: Any, place: Any) -> Any:
        return function if isinstance(terms, types.Array) or len(terms) else untouched

    overload(function, jit_options=_INLINED, strict=False)(choose)
    return function


def mapped_over_tuple(of_one: Any, result: type[NamedTuple]) -> Any:
    """Compile ``each(terms, place)``: the tuple of ``of_one(term, place)``, empty where there are no terms.

    Parameters
    ----------
    of_one : callable
        Inlined.
    result : NamedTuple
        What it returns. Of an array of terms an array of its records is made.
    """
    records, width = record_type(result), len(result._fields)

    def each(terms: Any, place: Any) -> Any:
        return tuple(of_one(term, place) for term in terms)

    def of_none(terms: Any, place: Any) -> Any:
        return ()

    def of_all(terms: Any, place: Any) -> Any:
        return (of_one(terms[0], place), *each(terms[1:], place))

    def of_array(terms: Any, place: Any) -> Any:
        numbers = np.empty(width * len(terms))
        for i in range(len(terms)):
            one = of_one(terms[i], place)
            for j in range(width):
                numbers[width * i + j] = one[j]
        return numbers.view(records)

    def choose(terms: Any, place: Any) -> Any:
        if isinstance(terms, types.Array):
            return of_array
        return of_all if len(terms) else of_none

    overload(each, jit_options=_INLINED, strict=False)(choose)
    return each


def chosen_by_field(field: str, having: Any) -> Callable[[Any], Any]:
    """Compile a function in one of two ways, by the types of its arguments: a caller's machine code has one alone.

    Parameters
    ----------
    field : str
        Where an argument is a named tuple with this field, `having` is compiled.
    having : callable
        Inlined, of the same arguments as the function that is decorated, which is compiled elsewhere.
    """

    def decorate(function: Any) -> Any:
        @wraps(function)
        def choose(*arguments: Any) -> Any:
            has = any(field in getattr(argument, "fields", ()) for argument in arguments)
            return having.py_func if has else function

        overload(function, jit_options=_INLINED, strict=False)(choose)
        return function

    return decorate


def record_type(fields: type[NamedTuple]) -> np.dtype[Any]:
    """Type of the records that stand for tuples of numbers, such as a `Harmonic`, in an array."""
    return np.dtype([(name, np.float64) for name in fields._fields], align=True)


def inlined_in_lanes(function: Callable[..., Any]) -> Any:
    """Compile a branch-free piece that LLVM inlines into a loop over lanes and vectorises."""
    return numba.njit(**_AS_WRITTEN | {"fastmath": _LANES})(function)


def inlined_as_written(function: Callable[..., Any]) -> Any:
    """Compile a scalar piece in which each operation is rounded once, as written: bounds are derived for that."""
    return numba.njit(**_AS_WRITTEN)(function)


def kernel(function: Callable[..., Any]) -> Any:
    """Compile an entry point called from Python, cached on disk."""
    return _cached(function, _CAREFUL)


def kernel_as_written(function: Callable[..., Any]) -> Any:
    """Compile an entry point of `inlined_as_written` pieces, cached on disk."""
    return _cached(function, False)


def lane_kernel(function: Callable[..., Any]) -> Any:
    """Compile an entry point that runs in lanes, cached on disk."""
    return _cached(function, _LANES)


before_compiling: ContextVar[Callable[[Any, tuple[Any, ...]], None] | None]
before_compiling = ContextVar("before_compiling", default=None)
"""What is called, in this thread, with a kernel and the types of its arguments before it is compiled or loaded."""


class _Kernel(Dispatcher):
    """A compiled entry point. Arguments that have a form of their own in kernels are handed over in that form."""

    def __call__(self, *arguments: Any) -> Any:
        return super().__call__(*(each.in_kernels if hasattr(each, "in_kernels") else each for each in arguments))

    def compile(self, sig: Any) -> Any:
        before = before_compiling.get()
        if before is not None:
            before(self, sig)
        return super().compile(sig)


def _cached(function: Callable[..., Any], fastmath: set[str] | bool) -> Any:
    # Numba reads its cache folder when a function is decorated; other users of Numba in this process keep theirs.
    elsewhere = config.CACHE_DIR
    config.CACHE_DIR = str(cache_folder(function.__code__.co_filename))
    try:
        compiled = numba.njit(**_AS_WRITTEN | {"fastmath": fastmath}, cache=True)(function)
    finally:
        config.CACHE_DIR = elsewhere
    if isinstance(compiled, Dispatcher):  # else compiling is switched off
        compiled.__class__ = _Kernel
    KERNELS.append(compiled)
    return compiled
