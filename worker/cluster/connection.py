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
from worker.errors import ClusterFailed
from worker.rounding import warn_if_unfused

_log = logging.getLogger("rattle.cluster")
_CONNECT_SECONDS = 10
_CLOSE_SECONDS = 10
_FORGET_SECONDS = 3
# Workers yield to whoever drives them, and more so to a service, which must answer while both cores compute.
_NICENESS = 8
# Each connection keeps its last messages for developers, a thousand by default: with catalogues in them, 100 MB.
_MESSAGES_KEPT = {"distributed.admin.low-level-log-length": 20}
# A worker holds the one task that it computes: when it dies, that one is to blame, and no other.
_ONE_TASK_A_WORKER = {"distributed.scheduler.worker-saturation": 1.0, "distributed.scheduler.allowed-failures": 1}
# Dask's parts answer over HTTP as well, and tell whoever asks what they do: they are left nothing to say.
_NO_PAGES: dict[str, list[str]] = {"distributed.scheduler.http.routes": [], "distributed.worker.http.routes": []}


class WarmKernels(WorkerPlugin):
    """Loads the compiled kernels before a worker takes its first tile, also after a nanny has restarted it."""

    name = "warm-kernels"

    def __init__(self, niceness: int = 0) -> None:
        self.niceness = niceness

    def setup(self, worker: object) -> None:
        """Load kernels and lower the priority of the worker's process; say so where it rounds otherwise than most."""
        if self.niceness:
            os.nice(self.niceness)
        warn_if_unfused()
        warm_up()


@contextlib.contextmanager
def local_cluster(workers: int = 2, compiling: Report | None = None) -> Iterator[Client]:
    """Client of an embedded cluster of single-threaded worker processes, which ends with the context.

    Parameters
    ----------
    workers : int
    compiling : callable, optional
        Called with how many kernels are there and how many are needed, while some have to be compiled.

    Yields
    ------
    distributed.Client
    """
    # For good: workers that a nanny has restarted connect later.
    dask.config.set(_MESSAGES_KEPT)
    # One process fills the disk cache of compiled kernels; the workers then find it filled.
    warm_up(compiling)
    settings = {
        "distributed.comm.timeouts.connect": f"{_CONNECT_SECONDS}s",
        # Nobody reads Dask's sampled profiles here, and workers and scheduler share two cores.
        "distributed.worker.profile.enabled": False,
        **_ONE_TASK_A_WORKER,
        **_NO_PAGES,
    }
    with dask.config.set(settings):
        cluster = LocalCluster(
            n_workers=workers, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0",
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
    """Kill the workers, then close what is left: a service stops in seconds, and no tile minds being killed.

    The other way round takes longer than anyone waits on a busy machine, and a `close` that has timed out leaves the
    cluster closing for ever: Dask then waits for it another ten seconds when the process ends.
    """
    kill_workers(cluster)
    # A scheduler that still believes in them would write to them as it closes, and tell of it in a traceback when
    # nothing silences it any more.
    patience = time.monotonic() + _FORGET_SECONDS
    while cluster.scheduler.workers and time.monotonic() < patience:
        time.sleep(0.01)
    with contextlib.suppress(TimeoutError):
        cluster.close(timeout=_CLOSE_SECONDS)


def kill_workers(cluster: LocalCluster) -> None:
    """Kill the workers of an embedded cluster, for good, and have their nannies give up what they shared with them."""
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
    # Not `with client`: that enters a context variable, and a service opens and closes its client in different threads.
    try:
        yield client
    finally:
        client.close(timeout=3)


@contextlib.contextmanager
def remote_cluster(address: str, certificates: Certificates | None = None) -> Iterator[Client]:
    """Client of a scheduler that runs elsewhere.

    Parameters
    ----------
    address : str
        As in ``tcp://host:8786`` or ``tls://host:8786``.
    certificates : Certificates
        What a ``tls://`` scheduler demands.

    Raises
    ------
    ClusterFailed
        Where nothing answers there, or it does not know these certificates.
    """
    dask.config.set(_MESSAGES_KEPT)
    try:
        client = Client(address, timeout=_CONNECT_SECONDS, set_as_default=False, security=_security(certificates))
    except (OSError, ValueError) as error:
        raise ClusterFailed(f"no Dask scheduler answers at {address}: {error}") from error
    with _closing(client):
        try:
            client.register_plugin(WarmKernels())
            _tell_of_settings(client, address)
        except OSError as error:  # its workers are being restarted
            raise ClusterFailed(f"the workers of {address} cannot be reached: {error}") from error
        yield client


def _tell_of_settings(client: Client, address: str) -> None:
    """Say where a scheduler was started without what the embedded one has."""
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
    """Client of the scheduler at `address`, or of an embedded cluster of `workers` where there is none.

    Kernels that an embedded cluster has to compile are reported to `compiling`, as those of `warm_up` are.
    """
    return remote_cluster(address, certificates) if address else local_cluster(workers, compiling)


def count_workers(client: Client, seconds: float) -> int:
    """Workers that the scheduler knows; 0 where it does not answer in time."""
    try:
        return len(client.sync(client.scheduler.ncores, callback_timeout=seconds))
    except (OSError, RuntimeError, TimeoutError):
        return 0
