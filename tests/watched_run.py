"""Any job in this thread, without a cluster, under a watch: how long its tasks go without a look at cancellation."""

import contextlib
import threading
import time
from unittest import mock

from worker.analyses import analysis as analyses
from worker.basins import tasks, whole_basin
from worker.errors import JobCancelled
from worker.run import run_job

_PAUSING = analyses, tasks, whole_basin


class Watch:
    """What tasks call in place of `stop_if_cancelled`. It notes the longest time between two calls, and ends the job.

    Time is this thread's on a processor, so that nothing else on the machine counts.

    Parameters
    ----------
    seconds, pauses : float
        The job is cancelled after so long, or so many calls.
    """

    def __init__(self, seconds=float("inf"), pauses=float("inf")):
        self.until, self.left = time.thread_time() + seconds, pauses
        self.longest, self.where, self.tasks = 0.0, "", 0
        self.last = time.thread_time()

    def begin(self):
        """A task begins."""
        self.tasks += 1
        self.last = time.thread_time()

    def look(self, where):
        """Note how long ago the last look was."""
        now = time.thread_time()
        if now - self.last > self.longest:
            self.longest, self.where = now - self.last, where
        self.last = now

    def __call__(self):
        """Pause."""
        self.look("before a pause")
        self.left -= 1
        if self.left < 0 or self.last > self.until:
            raise JobCancelled("the watch has ended")


class InThisThread:
    """Runs tasks as `worker.cluster.driver.Driver` does, one after another."""

    window_size = 1

    def __init__(self, watch):
        self.watch = watch

    def run_tasks(self, address, next_task, cancel, within=contextlib.nullcontext, compiling=None):
        while (task := next_task()) is not None:
            self.watch.begin()
            with within():
                receipt = task.function(*address, task.number, *task.arguments)
            self.watch.look(f"at the end of {task}")
            yield task, receipt


def run_watched(job, place, watch):
    """Run a job into a store. Returns whether it came to its end; other errors than the watch's pass."""
    with contextlib.ExitStack() as watched:
        for module in _PAUSING:
            watched.enter_context(mock.patch.object(module, "stop_if_cancelled", watch))
        try:
            run_job(job, str(place), InThisThread(watch), report=lambda _: None, cancel=threading.Event())
        except JobCancelled:
            return False
    return True
