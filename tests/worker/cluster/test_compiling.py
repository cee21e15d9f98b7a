"""A job says that its workers compile kernels, while they do."""

import threading

import numba
import pytest

from rattle_kernels.numerics import jit
from worker.cluster.calls import Compiling, Task
from worker.cluster.driver import Driver
from worker.cluster.threads import threads_here
from worker.progress import Progress, Stage

_WAIT_SECONDS = 60.0
_TOLD = threading.Event()


@numba.njit
def twice(number):
    return 2 * number


def double(location, digest, number):
    """Compile a kernel, and wait until the job has been told."""
    value = twice(number)
    return value, _TOLD.wait(_WAIT_SECONDS)


@pytest.fixture(scope="module")
def driver():
    with threads_here(1) as threads:
        yield Driver(threads)


def test_a_job_whose_workers_compile_is_told_and_other_jobs_are_not(driver, monkeypatch):
    monkeypatch.setattr(jit, "KERNELS", [*jit.KERNELS, twice])
    told = []

    def run(digest, number):
        def say():
            told.append(digest)
            _TOLD.set()

        tasks = iter([Task(double, number)])
        run_tasks = driver.run_tasks(("store", digest), lambda: next(tasks, None), threading.Event(), compiling=say)
        return [receipt for _, receipt in run_tasks]

    assert run("first", 4) == [(8, True)]
    assert run("second", 5) == [(10, True)]  # nothing is left to compile
    assert told == ["first"]


def test_a_job_is_told_once_for_each_time_that_a_worker_says_so():
    compiling = Compiling(None)
    for _ in range(2):
        compiling._take((0.0, ["store", "first"]))
        asked = [compiling.has_begun(("store", digest)) for digest in ("second", "first", "first")]
        assert asked == [False, True, False]


def test_what_is_done_stays_while_workers_compile():
    before = Progress(Stage.MAPPING, 1, 4, 100, 400, 50.0, 6.0, 0, 1)
    assert before.while_compiling() == Progress(Stage.COMPILING, 1, 4, 100, 400, 50.0, None, 0, 1)
