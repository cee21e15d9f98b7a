"""A worker that compiles a kernel leaves a cancelled task, and takes the next one."""

import os
import threading
import time
from pathlib import Path

import psutil
import pytest
from numba.extending import overload

from rattle_kernels.numerics.jit import kernel
from worker.cluster.calls import Task
from worker.cluster.connection import local_cluster
from worker.cluster.driver import Driver
from worker.errors import JobCancelled

# Longer than any test: nothing here waits for it.
_FOR_EVER_SECONDS = 600.0
_COMPILER = "RATTLE_TEST_COMPILER"


def _slowly_compiled(x):
    """The overload below takes its place."""


@overload(_slowly_compiled)
def _choose(x):
    Path(os.environ[_COMPILER]).write_text(str(os.getpid()))
    time.sleep(_FOR_EVER_SECONDS)
    return lambda x: x


@kernel
def never_there(x):
    return _slowly_compiled(x)


def use(location, digest, number):
    """Call a kernel that no disk cache holds."""
    return never_there(float(number))


def answer(location, digest, number):
    """What comes after it."""
    return number


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(_COMPILER, str(tmp_path_factory.mktemp("compiling") / "process"))
        with local_cluster(1) as client:
            yield Driver(client)


def run(driver, task, cancel, compiling):
    tasks = iter([task])
    done = driver.run_tasks(("store", str(task)), lambda: next(tasks, None), cancel, compiling=compiling)
    return [receipt for _, receipt in done]


@pytest.mark.slow
def test_a_cancelled_worker_leaves_a_kernel_that_compiles_for_ever(driver):
    cancel, told, place = threading.Event(), threading.Event(), Path(os.environ[_COMPILER])

    def cancel_when_it_compiles():
        while not (place.exists() and place.read_text() and told.is_set()):
            time.sleep(0.01)
        cancel.set()

    threading.Thread(target=cancel_when_it_compiles, daemon=True).start()
    with pytest.raises(JobCancelled):
        run(driver, Task(use, 1), cancel, told.set)
    # Its only worker would compile for ten minutes.
    assert run(driver, Task(answer, 5), threading.Event(), told.set) == [5]
    assert not psutil.pid_exists(int(place.read_text()))
