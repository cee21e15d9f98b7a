"""How many workers one driver keeps busy: ``python -m benchmarks.waiting_workers [THREADS ...]``.

Tasks only sleep, so that two cores stand for a large cluster: what is left is the work of driver, scheduler and
workers' connections. Every count of threads is tried with tasks as short as a tile, and with tasks of a second.
"""

import sys
import threading
import time
from contextlib import contextmanager

import dask
from distributed import Client, LocalCluster

from worker.cluster.calls import Task
from worker.cluster.connection import _EMBEDDED, _MESSAGES_KEPT
from worker.cluster.driver import Driver

THREADS = (10, 100, 512, 1_000)
TASK_SECONDS = (0.25, 1.0)
RUN_SECONDS = 60.0
# A process is one worker with many threads. Real workers are more processes, which need no processor here either.
_THREADS_A_PROCESS, _MOST_PROCESSES = 64, 16


def wait_a_while(location, digest, number, seconds):
    """A task that needs no processor."""
    time.sleep(seconds)
    return number


def keep_busy(client, threads, seconds):
    """Run tasks for about a minute; the part of the threads' time that they were busy, and tasks a second."""
    count = round(RUN_SECONDS / seconds) * threads
    tasks = (Task(wait_a_while, number, (seconds,)) for number in range(count))
    begin, own = time.perf_counter(), time.process_time()
    done = Driver(client).run_tasks(("store", "digest"), lambda: next(tasks, None), threading.Event())
    assert len({receipt for _, receipt in done}) == count
    wall = time.perf_counter() - begin
    return {
        "busy": count * seconds / threads / wall,
        "tasks_a_second": count / wall,
        "driver_and_scheduler_cores": (time.process_time() - own) / wall,
    }


@contextmanager
def cluster_of(threads):
    """A client of a cluster of this many threads, or a few more."""
    processes = min(-(-threads // _THREADS_A_PROCESS), _MOST_PROCESSES)
    options = {"n_workers": processes, "threads_per_worker": -(-threads // processes), "dashboard_address": ":0"}
    with (
        dask.config.set({**_MESSAGES_KEPT, **_EMBEDDED}),
        LocalCluster(processes=True, memory_limit=0, **options) as cluster,
        Client(cluster) as client,
    ):
        yield client


def main(counts):
    """Print a line for every count of threads."""
    for threads in counts:
        with cluster_of(threads) as client:
            for seconds in TASK_SECONDS:
                figures = keep_busy(client, sum(client.nthreads().values()), seconds)
                told = ", ".join(f"{name.replace('_', ' ')} {value:.3g}" for name, value in figures.items())
                print(f"{threads} threads, tasks of {seconds:g} s: {told}", flush=True)


if __name__ == "__main__":
    main([int(count) for count in sys.argv[1:]] or list(THREADS))
