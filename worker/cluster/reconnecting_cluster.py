"""A cluster for a service that outlives it: after a loss, the service reconnects to it or rebuilds it."""

import contextlib
import logging
import time
from collections.abc import Callable

from rattle_kernels.warm_up import Report
from worker.cluster.certificates import Certificates
from worker.cluster.connection import connect, count_workers, kill_workers
from worker.cluster.driver import Driver
from worker.errors import ClusterFailed

_log = logging.getLogger("rattle.cluster")
# Killed workers are back within seconds, on a busy machine after a minute. An embedded cluster that has had no worker
# for this long has lost their nannies.
_NO_WORKER_SECONDS = 240.0
_ANSWER_SECONDS = 2.0


class ReconnectingCluster:
    """The driver of a cluster, replaced by a new one after the cluster has been lost.

    It belongs to one thread. Other threads may call `workers` only.

    Parameters
    ----------
    address : str or None
        Address of a Dask scheduler. None means an embedded cluster.
    workers : int
        Number of workers of the embedded cluster.
    certificates : Certificates
        Required by a ``tls://`` scheduler.
    compiling : callable, optional
        Called with the numbers of ready and of needed kernels, while an embedded cluster has to compile some.
    retried : callable
        Called whenever a lost task is submitted again.
    """

    def __init__(
        self,
        address: str | None,
        workers: int,
        certificates: Certificates | None = None,
        compiling: Report | None = None,
        retried: Callable[[], None] = lambda: None,
    ) -> None:
        self._address, self._workers, self._certificates = address, workers, certificates
        self._compiling, self._retried = compiling, retried
        self._stack = contextlib.ExitStack()
        self._driver: Driver | None = None
        self._seen = 0.0
        self._logged = ""

    def open(self) -> None:
        """Connect. If no scheduler answers, `driver` tries again."""
        try:
            cluster = connect(self._address, self._workers, self._certificates, self._compiling)
            client = self._stack.enter_context(cluster)
        except ClusterFailed as error:
            if str(error) != self._logged:  # once, not every few seconds
                _log.warning("%s; trying again", error)
            self._logged = str(error)
            return
        if self._logged:
            _log.warning("the cluster is back")
        self._driver = Driver(client, self._retried)
        self._seen, self._logged = time.monotonic(), ""

    def driver(self) -> Driver | None:
        """Driver of a cluster that has a worker, None while there is none. Connects again if the cluster is lost."""
        count = self.workers()
        if count > 0:
            self._seen = time.monotonic()
            return self._driver
        if self._driver is not None and self._lost():
            _log.warning("the cluster is lost; connecting again")
            self._logged = "lost"
            self.close()
        if self._driver is None:
            self.open()
            count = self.workers()
        return self._driver if count > 0 else None

    def workers(self) -> int:
        """Number of workers that the scheduler knows; 0 if it does not answer."""
        driver = self._driver
        with contextlib.suppress(Exception):
            if driver is not None and driver.client.status == "running":
                return count_workers(driver.client, _ANSWER_SECONDS)
        return 0

    def _lost(self) -> bool:
        if self._driver is None or self._driver.client.status != "running":
            return True
        return self._address is None and time.monotonic() - self._seen > _NO_WORKER_SECONDS

    def close(self) -> None:
        """Disconnect, and end an embedded cluster."""
        self._driver = None
        try:
            self._stack.close()
        except Exception:  # a lost cluster need not close in order
            _log.debug("closing a lost cluster", exc_info=True)

    def drop(self) -> None:
        """Kill embedded workers. The rest ends with this process, because Dask takes seconds to close it."""
        if self._driver is not None and self._address is None:
            kill_workers(self._driver.client.cluster)
