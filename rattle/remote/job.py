"""A job of a service: followed, opened, cancelled."""

import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import httpx2 as httpx

from rattle.progress import ProgressLine, console_for, progress_line
from rattle.remote.failure import ServiceFailed, detail_of

if TYPE_CHECKING:
    import xarray as xr

    from rattle.remote.service import Service

# An idle stream of events sends a comment every 15 s.
_SILENCE_SECONDS = 40.0
_PATIENCE_SECONDS = 60.0
_PAUSE_SECONDS = 0.5
_ENDS = ("succeeded", "failed", "cancelled")


class RemoteJob:
    """A job of a service.

    Parameters
    ----------
    service : Service
    described : dict
        As the service describes it.

    Examples
    --------
    >>> import rattle
    >>> there = rattle.connect("http://127.0.0.1:8000")
    >>> job = there.submit(rattle.GrazingCurveJob(order=1)).wait(progress=False)
    >>> job.state, job.progress["stage"]
    ('succeeded', 'done')
    >>> job.open().sizes["order"], rattle.open(job.url).rattle.kind
    (2, 'grazing_curve')
    >>> job.fetch("curve.zarr", progress=False).sizes["order"]
    2
    """

    def __init__(self, service: "Service", described: dict[str, Any]) -> None:
        self.service, self.described = service, described

    def __repr__(self) -> str:
        return f"<job {self.id}: {self.kind}, {self.described['state']}>"

    @property
    def id(self) -> str:
        """Its name in the service."""
        return str(self.described["id"])

    @property
    def kind(self) -> str:
        """Kind of the job."""
        return str(self.described["kind"])

    @property
    def state(self) -> str:
        """Its state now: queued, running, cancelling, succeeded, failed or cancelled."""
        return str(self._renewed()["state"])

    @property
    def progress(self) -> dict[str, Any] | None:
        """How far it is now; None before it begins."""
        found: dict[str, Any] | None = self._renewed()["progress"]
        return found

    @property
    def url(self) -> str:
        """Address of its result, which `rattle.open` takes."""
        return self.service.url + str(self.described["links"]["zarr"])

    def _renewed(self) -> dict[str, Any]:
        if self.described["state"] not in _ENDS:  # the ends never change
            self.described = self.service.ask("GET", f"/v1/jobs/{self.id}")
        return self.described

    def wait(self, progress: bool = True) -> "RemoteJob":
        """Wait for the end of the job. An interrupt stops the waiting, not the job.

        Parameters
        ----------
        progress : bool
            Whether progress is shown on a terminal and in a notebook.

        Returns
        -------
        RemoteJob
            Itself.

        Raises
        ------
        ServiceFailed
            If the service is gone for a minute.
        """
        with progress_line(console_for(progress)) as line:
            self.follow(line)
        return self

    def follow(self, line: ProgressLine) -> None:
        """Wait for the end, and show events as they come; a stream that breaks is opened again."""
        seen, patience = "0", time.monotonic() + _PATIENCE_SECONDS
        while True:
            try:
                for number, event in self._events(seen):
                    seen = number
                    _show(event["progress"], line)
                    if event["state"] in _ENDS:
                        _show(self._renewed()["progress"], line)  # the last one is written with the end
                        return
                    patience = time.monotonic() + _PATIENCE_SECONDS
            except (httpx.HTTPError, ServiceFailed) as error:  # the service is being restarted, perhaps
                if isinstance(error, ServiceFailed) and error.request_is_wrong:
                    raise
                if time.monotonic() > patience:
                    message = f"{self.service.url} does not answer any more ({error}); the job goes on"
                    raise ServiceFailed(f"{message}: look with `rattle jobs`") from error
            time.sleep(_PAUSE_SECONDS)

    def _events(self, seen: str) -> Iterator[tuple[str, dict[str, Any]]]:
        """Numbers and data of the events after the last one seen, as long as the stream lasts."""
        headers, address = self.service.headers | {"last-event-id": seen}, f"/v1/jobs/{self.id}/events"
        fields: dict[str, str] = {}
        with httpx.stream("GET", self.service.url + address, headers=headers, timeout=_SILENCE_SECONDS) as answer:
            if answer.is_client_error:
                answer.read()
                raise ServiceFailed(detail_of(answer), answer.status_code)
            answer.raise_for_status()
            for text in answer.iter_lines():
                name, _, value = text.partition(": ")
                fields[name] = value
                if not text and "data" in fields:
                    yield fields["id"], json.loads(fields["data"])
                    fields = {}

    def result(self) -> dict[str, Any]:
        """Summary of the result as JSON, complete or not.

        Raises
        ------
        ServiceFailed
            If there is none yet.
        """
        found: dict[str, Any] = self.service.ask("GET", f"/v1/jobs/{self.id}/result")
        return found

    def open(self) -> "xr.Dataset":
        """The result as a dataset, read over HTTP when its values are used; complete or not.

        Raises
        ------
        StoreConflict
            If there is none yet.
        """
        from rattle.results.opening import open

        return open(self.url, key=self.service.key)

    def fetch(self, store: str | Path, *, progress: bool = True) -> "xr.Dataset":
        """The result, copied into a folder here. It is the store of the service, to the byte.

        Parameters
        ----------
        store : str or path
            Folder to make.
        progress : bool
            Whether progress is shown on a terminal and in a notebook.

        Returns
        -------
        xarray.Dataset

        Raises
        ------
        StoreConflict
            If the folder is there already.
        ServiceFailed
            If the job has not ended, has no result, or the service does not answer.
        OSError
            If the folder cannot be written.
        """
        from rattle.remote.fetching import fetch_store
        from rattle.results.opening import open

        if self.state not in _ENDS:
            raise ServiceFailed(f"job {self.id} is {self.described['state']}: fetch its result once it has ended")
        fetch_store(self.url, self.service.headers, Path(store), console_for(progress))
        return open(store)

    def cancel(self) -> "RemoteJob":
        """Stop it; what it has computed stays readable.

        Returns
        -------
        RemoteJob
            Itself.

        Raises
        ------
        ServiceFailed
        """
        self.described = self.service.ask("POST", f"/v1/jobs/{self.id}/cancel")
        return self

    def delete(self) -> None:
        """Delete it with its result.

        Raises
        ------
        ServiceFailed
        """
        self.service.ask("DELETE", f"/v1/jobs/{self.id}")

    def demand_success(self) -> None:
        """Raise the error of a job that did not succeed.

        Raises
        ------
        ServiceFailed
        """
        described = self._renewed()
        if described["state"] != "succeeded":
            detail = f": {described['error']['detail']}" if described["error"] else ""
            raise ServiceFailed(f"job {self.id} is {described['state']}{detail}")


def _show(progress: dict[str, Any] | None, line: ProgressLine) -> None:
    if progress:
        tiles, basins = ((progress[f"{what}_done"], progress[f"{what}_total"]) for what in ("tiles", "basins"))
        line.show(progress["stage"], tiles, basins, progress["cells_per_second"])
