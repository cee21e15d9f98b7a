"""A cluster of threads ends soon, also while one of them cannot leave its task."""

import threading
import time

import pytest

from worker.cluster.calls import stop_if_cancelled
from worker.cluster.connection import thread_cluster
from worker.errors import JobCancelled

_begun, _compiled, _left = threading.Event(), threading.Event(), threading.Event()


def _compile_and_go_on():
    _begun.set()
    _compiled.wait()
    try:
        while True:
            stop_if_cancelled()
            time.sleep(0.01)
    except JobCancelled:
        _left.set()
        raise


def _fail():
    raise ZeroDivisionError("the task's own error")


def test_a_thread_that_compiles_does_not_hide_an_error_and_leaves_its_task_afterwards():
    with pytest.raises(ZeroDivisionError), thread_cluster(2) as client:
        compiling = client.submit(_compile_and_go_on)
        assert _begun.wait(30)
        assert not compiling.done()
        client.submit(_fail).result()
    _compiled.set()
    assert _left.wait(30)
