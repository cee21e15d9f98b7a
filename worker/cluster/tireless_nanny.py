"""A nanny that starts its worker again however often it is killed, and however long it takes to come back."""

from typing import Any

from distributed import Nanny


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
