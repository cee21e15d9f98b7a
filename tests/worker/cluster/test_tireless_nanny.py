"""An embedded worker that dies is replaced, however long that takes and whenever it dies."""

import asyncio
import os
import signal

import dask
import psutil
import pytest
from distributed import SchedulerPlugin

from worker.cluster.connection import local_cluster

PATIENCE = 100.0
pytestmark = pytest.mark.timeout(400)


@pytest.fixture
def client():
    """Client of one worker, in a cluster that soon gives up those that it misses."""
    with dask.config.set({"distributed.deploy.lost-worker-timeout": "10ms"}), local_cluster(workers=1) as client:
        yield client


def computed_by(client):
    """Number of the process that runs a task."""
    return client.submit(os.getpid, pure=False).result(timeout=PATIENCE)


class DiesAsItRegisters(SchedulerPlugin):
    """Kills the next worker after the scheduler has entered it, and before the worker hears of that."""

    victim = None

    async def add_worker(self, scheduler, worker):
        if self.victim is None:
            self.victim = scheduler.workers[worker].pid
            os.kill(self.victim, signal.SIGKILL)
            while psutil.pid_exists(self.victim):
                await asyncio.sleep(0.05)
            await asyncio.sleep(0.05)  # for the end of the connection


@pytest.mark.slow
def test_a_worker_that_is_missed_for_long_comes_back(client):
    first = computed_by(client)
    os.kill(first, signal.SIGKILL)
    second = computed_by(client)
    os.kill(second, signal.SIGKILL)
    assert len({first, second, computed_by(client)}) == 3


@pytest.mark.slow
def test_a_worker_that_died_as_it_registered_does_not_keep_the_next_one_out(client):
    first, plugin = computed_by(client), DiesAsItRegisters()
    client.cluster.scheduler.add_plugin(plugin)
    os.kill(first, signal.SIGKILL)
    assert computed_by(client) not in (first, plugin.victim)
    assert plugin.victim is not None
