"""The Dask cluster: two local worker processes by default, or any scheduler by its address."""

import contextlib
import logging
import os
import signal
import time
from collections.abc import Iterator

import dask
from distributed import Client, LocalCluster, Security, WorkerPlugin

from rattle_kernels import warm_up
from rattle_kernels.warm_up import Report
from worker.cluster.certificates import Certificates
from worker.cluster.tireless_nanny import TirelessNanny
from worker.errors import ClusterFailed
from worker.rounding import warn_if_unfused

_log = logging.getLogger("rattle.cluster")
_CONNECT_SECONDS = 10
_CLOSE_SECONDS = 10
_FORGET_SECONDS = 3
# Tasks look several times a second whether they are cancelled.
_LEAVE_SECONDS = 1
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


@contextlib.contextmanager
def thread_cluster(threads: int) -> Iterator[Client]:
    """Client of an embedded cluster of threads of this process, which start within a tenth of a second.

    Kernels release the GIL. They are compiled, or loaded from the disk cache, when a task first needs them.

    Parameters
    ----------
    threads : int

    Yields
    ------
    distributed.Client
    """
    dask.config.set(_MESSAGES_KEPT)
    with dask.config.set(_EMBEDDED):
        cluster = LocalCluster(
            n_workers=1, threads_per_worker=threads, processes=False, memory_limit=0, dashboard_address="127.0.0.1:0",
            worker_dashboard_address="127.0.0.1:0",
            silence_logs=logging.CRITICAL, scheduler_kwargs={"dashboard": False},
        )  # fmt: skip
    try:
        with _closing(Client(cluster, set_as_default=False)) as client:
            yield client
    finally:
        _end_threads(cluster)


def _end_threads(cluster: LocalCluster) -> None:
    """Close an embedded cluster of threads once its tasks have left, or soon: one that compiles a kernel cannot.

    Such a thread leaves its task by itself when the kernel is there. `close` alone would wait for it, then fail.
    """
    workers = list(cluster.workers.values())
    patience = time.monotonic() + _LEAVE_SECONDS
    while any(worker.state.executing for worker in workers) and time.monotonic() < patience:
        time.sleep(0.01)
    for worker in workers:
        cluster.sync(worker.close, executor_wait=False)
    cluster.close(timeout=_CLOSE_SECONDS)


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
