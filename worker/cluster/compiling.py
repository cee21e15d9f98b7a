"""Jobs for which workers compile kernels: a worker tells the driver, by an event of Dask's, before the first of them.

Kernels for one, two and more harmonics are compiled when a job first needs them, and nothing else happens for a minute
or so.
"""

import contextlib
import threading
from collections.abc import Iterator
from typing import Any

from distributed import Client, get_worker

from rattle_kernels.numerics.jit import watch_compiling

Address = tuple[str, str]
"""Location of a job's store, and digest of the job."""
_TOPIC = "rattle-compiling"


@contextlib.contextmanager
def telling_of_compilation(address: Address) -> Iterator[None]:
    """Tell the driver once if a kernel is compiled while a context lasts. Called on a worker.

    Parameters
    ----------
    address : (str, str)
        The job's.
    """
    worker, told = get_worker(), False

    def tell() -> None:
        nonlocal told
        if not told:
            told = True
            worker.log_event(_TOPIC, list(address))

    with watch_compiling(tell):
        yield


class Compiling:
    """Jobs of which a worker has said that it compiles kernels, and that have not been asked about since.

    Parameters
    ----------
    client : distributed.Client
    """

    def __init__(self, client: Client) -> None:
        self._client, self._jobs = client, set[Address]()
        self._lock, self._listens = threading.Lock(), False

    def listen(self) -> None:
        """Hear what workers say from now on."""
        with self._lock:
            if not self._listens:
                self._client.subscribe_topic(_TOPIC, self._take)
            self._listens = True

    def _take(self, event: tuple[float, Any]) -> None:
        location, digest = event[1]
        self._jobs.add((location, digest))

    def has_begun(self, address: Address) -> bool:
        """Whether a worker has begun to compile for a job since this was last asked."""
        if address not in self._jobs:
            return False
        self._jobs.discard(address)
        return True
