"""The Dask cluster: two local worker processes by default, or any scheduler by its address.

`ReconnectingCluster` is that of a service, which outlives it: after a loss, the service connects again or rebuilds it.
"""

import contextlib
import logging
import os
import signal
import time
from collections.abc import Callable, Iterator
from typing import Any, cast

import dask
from distributed import Client, LocalCluster, Nanny, Security, WorkerPlugin

from rattle_kernels import warm_up
from rattle_kernels.warm_up import Report
from worker.cluster.driver import Driver
from worker.cluster.settings import Certificates
from worker.errors import ClusterFailed
from worker.rounding import warn_if_unfused

_log = logging.getLogger("rattle.cluster")
# Killed workers are back within seconds, on a busy machine after a minute. An embedded cluster that has had no worker
# for this long has lost their nannies.
_NO_WORKER_SECONDS = 240.0
_ANSWER_SECONDS = 2.0
_CONNECT_SECONDS = 10
_CLOSE_SECONDS = 10
_FORGET_SECONDS = 3
# Workers yield to the driver, and even more to a service, which must answer while both cores compute.
_NICENESS = 8
# Each connection keeps its last messages for debugging. The default of a thousand takes 100 MB with catalogues in them.
_MESSAGES_KEPT = {"distributed.admin.low-level-log-length": 20}
# A worker holds only the task that it computes. When it dies, no other task is blamed.
_ONE_TASK_A_WORKER = {"distributed.scheduler.worker-saturation": 1.0, "distributed.scheduler.allowed-failures": 1}
# Dask's scheduler and workers also serve status pages over HTTP, open to anyone. They are switched off.
_NO_PAGES: dict[str, list[str]] = {"distributed.scheduler.http.routes": [], "distributed.worker.http.routes": []}


# What nobody reads is not measured: an idle cluster of two workers then takes 2 % of a core, not 12 %.
_UNMEASURED = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "500ms",
    "distributed.admin.system-monitor.interval": "5s",
    "distributed.worker.memory.monitor-interval": "1s",
}
# Arrays of a tile are used again, not given back to the system after each: new pages took a third of a worker's time
# where tiles are short. glibc takes no more than 32 MiB for the second.
_MEMORY_KEPT = {
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": 64 * 2**20,
    "distributed.nanny.pre-spawn-environ.MALLOC_MMAP_THRESHOLD_": 32 * 2**20,
}
_EMBEDDED = {**_UNMEASURED, **_ONE_TASK_A_WORKER, **_NO_PAGES, **_MEMORY_KEPT}


class TirelessNanny(Nanny):
    """Its workers have their addresses for names, so Dask never gives up the nanny itself.

    A local cluster names a worker after its nanny. It closes a nanny for good when no worker of that name has come back
    15 s after a death, which is soon on a busy machine. And a worker that dies while it registers is remembered for
    minutes: the next one of that name is refused, and the nanny then closes itself. With the last nanny gone, nothing
    happens until the driver gives up.

    Parameters
    ----------
    scheduler : str
        Its address.
    name : int
        What the cluster calls this nanny.
    **options : object
        Of `distributed.Nanny`.
    """

    def __init__(self, scheduler: str, *, name: int, **options: Any) -> None:
        super().__init__(scheduler, **options)


class WarmKernels(WorkerPlugin):
    """Loads the compiled kernels before a worker's first tile, also after a nanny has restarted it."""

    name = "warm-kernels"

    def __init__(self, niceness: int = 0) -> None:
        self.niceness = niceness

    def setup(self, worker: object) -> None:
        """Load kernels and lower the priority of the worker's process; warn if it rounds unlike most."""
        if self.niceness:
            os.nice(self.niceness)
        warn_if_unfused()
        warm_up()


@contextlib.contextmanager
def local_cluster(workers: int = 2, compiling: Report | None = None) -> Iterator[Client]:
    """Client of an embedded cluster of single-threaded worker processes. The cluster ends with the context.

    Parameters
    ----------
    workers : int
    compiling : callable, optional
        Called with the numbers of ready and of needed kernels, while some have to be compiled.

    Yields
    ------
    distributed.Client
    """
    # Not only within this context: workers that a nanny has restarted connect later.
    dask.config.set(_MESSAGES_KEPT)
    # This process fills the disk cache of compiled kernels for the workers.
    warm_up(compiling)
    with dask.config.set({"distributed.comm.timeouts.connect": f"{_CONNECT_SECONDS}s", **_EMBEDDED}):
        cluster = LocalCluster(
            n_workers=workers, threads_per_worker=1, worker_class=TirelessNanny, dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL, host="127.0.0.1", protocol="tls://", security=Security.temporary(),
            scheduler_kwargs={"dashboard": False},
        )  # fmt: skip
    try:
        with _closing(Client(cluster, set_as_default=False)) as client:
            client.register_plugin(WarmKernels(_NICENESS))
            yield client
    finally:
        _end(cluster)


def _end(cluster: LocalCluster) -> None:
    """Kill the workers, then close the rest. So a service stops in seconds, and killed tiles do no harm.

    The opposite order takes too long on a busy machine. A `close` that has timed out leaves the cluster closing
    forever, and Dask waits another ten seconds for it when the process ends.
    """
    kill_workers(cluster)
    # A scheduler that does not know yet that they are gone writes to them while closing, and logs a traceback.
    patience = time.monotonic() + _FORGET_SECONDS
    while cluster.scheduler.workers and time.monotonic() < patience:
        time.sleep(0.01)
    with contextlib.suppress(TimeoutError):
        cluster.close(timeout=_CLOSE_SECONDS)


def kill_workers(cluster: LocalCluster) -> None:
    """Kill the workers of an embedded cluster for good, and let their nannies release what they shared with them."""
    nannies = list(cluster.workers.values())
    for nanny in nannies:
        nanny.close_gracefully("killed")  # or it would start another one
        with contextlib.suppress(ProcessLookupError, TypeError):  # gone by itself, or never started
            os.kill(nanny.pid, signal.SIGKILL)
    patience = time.monotonic() + _FORGET_SECONDS
    while any(nanny.process and nanny.process.process for nanny in nannies) and time.monotonic() < patience:
        time.sleep(0.01)


@contextlib.contextmanager
def _closing(client: Client) -> Iterator[Client]:
    # Not `with client`: that sets a context variable, and a service opens and closes its client in different threads.
    try:
        yield client
    finally:
        client.close(timeout=3)


@contextlib.contextmanager
def remote_cluster(address: str, certificates: Certificates | None = None) -> Iterator[Client]:
    """Client of a scheduler on another machine.

    Parameters
    ----------
    address : str
        For example ``tcp://host:8786`` or ``tls://host:8786``.
    certificates : Certificates
        Required by a ``tls://`` scheduler.

    Raises
    ------
    ClusterFailed
        If nothing answers there, or the scheduler does not accept these certificates.
    """
    dask.config.set(_MESSAGES_KEPT)
    try:
        client = Client(address, timeout=_CONNECT_SECONDS, set_as_default=False, security=_security(certificates))
    except (OSError, ValueError) as error:
        raise ClusterFailed(f"no Dask scheduler answers at {address}: {error}") from error
    with _closing(client):
        try:
            client.register_plugin(WarmKernels())
            _warn_of_settings(client, address)
        except OSError as error:  # its workers are being restarted
            raise ClusterFailed(f"the workers of {address} cannot be reached: {error}") from error
        yield client


def _warn_of_settings(client: Client, address: str) -> None:
    """Warn of a scheduler that lacks settings of the embedded one."""
    for name, right in _ONE_TASK_A_WORKER.items():
        found = client.run_on_scheduler(dask.config.get, name)
        if found != right:
            variable = "DASK_" + name.replace(".", "__").replace("-", "_").upper()
            _log.warning(
                "the scheduler at %s has %s = %s: start it with %s=%s, so that no tile is blamed for another's worker",
                address, name, found, variable, right,
            )  # fmt: skip


def _security(certificates: Certificates | None) -> Security | None:
    if certificates is None:
        return None
    for file in (certificates.authority, certificates.certificate, certificates.key):
        if not file.is_file():
            raise ClusterFailed(f"there is no certificate or key at {file}; `rattle certs` makes them")
    return Security(
        tls_ca_file=str(certificates.authority), tls_client_cert=str(certificates.certificate),
        tls_client_key=str(certificates.key), require_encryption=True,
    )  # fmt: skip


def connect(
    address: str | None,
    workers: int,
    certificates: Certificates | None = None,
    compiling: Report | None = None,
) -> contextlib.AbstractContextManager[Client]:
    """Client of the scheduler at `address`; without an address, of an embedded cluster of `workers`.

    Kernels that an embedded cluster has to compile are reported to `compiling`, as in `warm_up`.
    """
    return remote_cluster(address, certificates) if address else local_cluster(workers, compiling)


def count_workers(client: Client, seconds: float) -> int:
    """Number of workers that the scheduler knows; 0 if it does not answer in time."""
    try:
        return len(client.sync(client.scheduler.ncores, callback_timeout=seconds))
    except (OSError, RuntimeError, TimeoutError):
        return 0


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
            kill_workers(cast(Client, self._driver.client).cluster)
