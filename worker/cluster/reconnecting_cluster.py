"""A cluster for a service that outlives it: what has been lost is connected to, or built, again."""

import contextlib
import logging
import time

from rattle_kernels.warm_up import Report
from worker.cluster.certificates import Certificates
from worker.cluster.connection import Client, connect, count_workers, kill_workers
from worker.errors import ClusterFailed

_log = logging.getLogger("rattle.cluster")
# Killed workers are back within seconds, on a busy machine after a minute; an embedded cluster without any for so long
# has lost their nannies.
_NO_WORKER_SECONDS = 240.0
_ANSWER_SECONDS = 2.0


class LastingCluster:
    """The client of a cluster, made anew when it has been lost.

    Of one thread: only `workers` may be called by others.

    Parameters
    ----------
    address : str or None
        Of a Dask scheduler; None for an embedded cluster.
    workers : int
        Of the embedded cluster.
    certificates : Certificates
        What a ``tls://`` scheduler demands.
    compiling : callable, optional
        Called with how many kernels are there and how many are needed, while an embedded cluster has to compile some.
    """

    def __init__(
        self,
        address: str | None,
        workers: int,
        certificates: Certificates | None = None,
        compiling: Report | None = None,
    ) -> None:
        self._address, self._workers, self._certificates = address, workers, certificates
        self._compiling = compiling
        self._stack = contextlib.ExitStack()
        self._client: Client | None = None
        self._seen = 0.0
        self._told = ""

    def open(self) -> None:
        """Connect; where no scheduler answers, later will do."""
        try:
            cluster = connect(self._address, self._workers, self._certificates, self._compiling)
            self._client = self._stack.enter_context(cluster)
        except ClusterFailed as error:
            if str(error) != self._told:  # once, not every few seconds
                _log.warning("%s; trying again", error)
            self._told = str(error)
            return
        if self._told:
            _log.warning("the cluster is back")
        self._seen, self._told = time.monotonic(), ""

    def client(self) -> Client | None:
        """The client of a cluster that has a worker, connected to anew if need be; None while there is none."""
        there = self.workers()
        if there > 0:
            self._seen = time.monotonic()
            return self._client
        if self._client is not None and self._lost():
            _log.warning("the cluster is lost; connecting again")
            self._told = "lost"
            self.close()
        if self._client is None:
            self.open()
            there = self.workers()
        return self._client if there > 0 else None

    def workers(self) -> int:
        """Workers that the scheduler knows; 0 where it does not answer."""
        client = self._client
        with contextlib.suppress(Exception):
            if client is not None and client.status == "running":
                return count_workers(client, _ANSWER_SECONDS)
        return 0

    def _lost(self) -> bool:
        if self._client is None or self._client.status != "running":
            return True
        return self._address is None and time.monotonic() - self._seen > _NO_WORKER_SECONDS

    def close(self) -> None:
        """Disconnect, and end an embedded cluster."""
        self._client = None
        try:
            self._stack.close()
        except Exception:  # what is lost need not close in order
            _log.debug("closing a lost cluster", exc_info=True)

    def drop(self) -> None:
        """Kill embedded workers and leave the rest to the end of this process: Dask takes seconds to close it."""
        if self._client is not None and self._address is None:
            kill_workers(self._client.cluster)
