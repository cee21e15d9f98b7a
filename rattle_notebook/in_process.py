"""The service's application in this process: it is asked by calls, opens no port, and ends with the process."""

import asyncio
import atexit
import functools
import json
import os
import tempfile
import threading
from collections.abc import Coroutine, Mapping
from email.utils import formatdate
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import httpx2 as httpx

from service.app import create_app
from service.settings import Settings
from worker.jobs.job import Job
from worker.kinds import KINDS
from worker.storage.location import result_location

_T = TypeVar("_T")
# Its body is sent on as it is once it has been read, so it has no longer the length and the coding that these name.
_OF_THE_LINE = ("content-encoding", "content-length", "transfer-encoding")


class Answer(NamedTuple):
    """Answer to a request."""

    status: int
    headers: dict[str, str]
    body: bytes


class InProcess:
    """The application with its runner, as long as this process lives."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="rattle-explorer-", ignore_cleanup_errors=True)
        settings = Settings(
            data=Path(self._folder.name), database_url=None, store=None, host="127.0.0.1", require_keys=False,
            log_level="error", keep_days=None, keep_gb=None,
        )  # fmt: skip
        self._results = settings.results
        self._app = create_app(settings)
        self._loop = asyncio.new_event_loop()
        threading.Thread(target=self._loop.run_forever, name="rattle-explorer", daemon=True).start()
        self._client = self._run(self._open())
        atexit.register(self.close)

    def _run(self, work: Coroutine[Any, Any, _T]) -> _T:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result()

    async def _open(self) -> httpx.AsyncClient:
        self._life = self._app.router.lifespan_context(self._app)
        await self._life.__aenter__()
        transport = httpx.ASGITransport(self._app, raise_app_exceptions=False)
        return httpx.AsyncClient(transport=transport, base_url="http://localhost")

    def close(self) -> None:
        """Stop what runs, and remove what was computed."""
        atexit.unregister(self.close)
        self._run(self._client.aclose())
        self._run(self._life.__aexit__(None, None, None))
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._folder.cleanup()

    def ask(self, method: str, path: str, headers: Mapping[str, str] | None = None, body: str | None = None) -> Answer:
        """Answer a request, as the service would.

        Parameters
        ----------
        method : str
        path : str
            With its query.
        headers : mapping, optional
        body : str, optional

        Returns
        -------
        Answer
        """
        asked = self._client.request(method, path, headers=dict(headers or {}), content=body)
        response = self._run(asked)
        kept = {name: value for name, value in response.headers.items() if name not in _OF_THE_LINE}
        kept["date"] = formatdate(usegmt=True)  # a server adds it, by which the page knows a new job
        return Answer(response.status_code, kept, response.content)

    def adopt(self, job: Job, location: str) -> str:
        """Let a result that lies in a folder here be one of the application's.

        Parameters
        ----------
        job : Job
        location : str
            Of its store, which is complete.

        Returns
        -------
        str
            Id of the job that answers the request.
        """
        jobs = self._app.state.jobs
        if jobs.answering(job) is None:
            name = jobs.leave_store(job)
            os.makedirs(self._results, exist_ok=True)
            os.symlink(os.path.abspath(location), result_location(self._results, name))
        answer = self.ask(
            "POST", f"/v1/{KINDS[job.kind].path}", {"content-type": "application/json"}, json.dumps(job.request())
        )
        return str(json.loads(answer.body)["id"])

    def location_of(self, job_id: str) -> str:
        """Where the store of a job is."""
        record = self._app.state.jobs.get(job_id)
        return result_location(self._results, record.store or record.id)


@functools.cache
def in_process() -> InProcess:
    """The application of this process: one, however many widgets there are."""
    return InProcess()
