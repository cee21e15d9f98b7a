"""Kernels compiled in a process of their own.

A thread that compiles cannot be stopped, and holds up the other threads of its process. A process can be killed. It
puts the machine code into the disk cache, from which the thread that needs it loads it in milliseconds.
"""

import contextlib
import os
import pickle
import queue
import select
import subprocess
import sys
import threading
from collections.abc import Iterator
from importlib import import_module
from typing import Any

from numba.core import event

from rattle_kernels.numerics import jit
from rattle_kernels.numerics.pausing import Pause

_PAUSE_SECONDS = 0.1
_ONE_AT_A_TIME = threading.Lock()


@contextlib.contextmanager
def compiled_apart(pause: Pause) -> Iterator[None]:
    """Compile kernels that the disk cache lacks in another process, in this thread and while the context lasts.

    Where that process cannot do it, or its machine code does not come to the cache, kernels are compiled as usual.

    Parameters
    ----------
    pause : callable
        Called several times a second meanwhile. An exception raised there kills the process.
    """
    compiler = _Compiler(pause)
    outside = jit.before_compiling.set(compiler.compile)
    try:
        yield
    finally:
        jit.before_compiling.reset(outside)
        compiler.close()


class _Compiler:
    """The other process, started when it is first needed."""

    def __init__(self, pause: Pause) -> None:
        self._pause = pause
        self._process: subprocess.Popen[bytes] | None = None

    def compile(self, kernel: Any, signature: tuple[Any, ...]) -> None:
        """Have a kernel compiled, unless it is there."""
        place = kernel.py_func.__module__, kernel.py_func.__name__
        if getattr(sys.modules[place[0]], place[1], None) is not kernel or _is_cached(kernel, signature):
            return
        while not _ONE_AT_A_TIME.acquire(timeout=_PAUSE_SECONDS):  # another thread may compile the same
            self._pause()
        try:
            if not _is_cached(kernel, signature):
                with event.trigger_event("numba:compile", data={"dispatcher": kernel, "args": signature}):
                    self._ask((*place, signature))
        finally:
            _ONE_AT_A_TIME.release()

    def _ask(self, request: tuple[Any, ...]) -> None:
        if self._process is None:
            # The same sources: another copy of the package would fill another cache.
            environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
            command = [sys.executable, "-m", __name__]
            self._process = subprocess.Popen(
                command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0
            )
        requests, answers = self._process.stdin, self._process.stdout
        assert requests is not None and answers is not None
        with contextlib.suppress(BrokenPipeError):
            requests.write(pickle.dumps(request))
        while not select.select([answers], [], [], _PAUSE_SECONDS)[0]:
            self._pause()
        answers.read(1)  # nothing where it has ended

    def close(self) -> None:
        """Kill the process, whatever it does."""
        if self._process is not None:
            self._process.kill()
            self._process.communicate()


def _is_cached(kernel: Any, signature: tuple[Any, ...]) -> bool:
    """Whether the machine code lies in the disk cache; it is not loaded."""
    cache = kernel._cache
    key = cache._index_key(signature, kernel.targetctx.codegen())
    return cache._cache_file.load(key) is not None


def _serve() -> None:
    """Compile what is asked for, until the process that asks is gone."""
    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)  # what is printed while compiling is no answer
    asked: queue.SimpleQueue[tuple[str, str, tuple[Any, ...]]] = queue.SimpleQueue()

    def listen() -> None:
        with contextlib.suppress(EOFError):
            while True:
                asked.put(pickle.load(sys.stdin.buffer))
        os._exit(0)

    threading.Thread(target=listen, daemon=True).start()
    while True:
        module, name, signature = asked.get()
        getattr(import_module(module), name).compile(signature)
        answers.write(b".")


if __name__ == "__main__":
    _serve()
