"""A service elsewhere, as the command line asks it. Neither Numba nor Dask is loaded for that."""

import json
from typing import Any

import httpx2 as httpx

from rattle.remote.failure import ServiceFailed, detail_of
from rattle.remote.job import RemoteJob
from worker.kinds import KINDS

_ANSWER_SECONDS = 30.0


class ServiceClient:
    """A service as the command line asks it: requests, jobs and their results.

    Parameters
    ----------
    url : str
    key : str, optional
    """

    def __init__(self, url: str, key: str | None = None) -> None:
        self.url, self.key = url.rstrip("/"), key

    def __repr__(self) -> str:
        return f"<service at {self.url}>"

    @property
    def headers(self) -> dict[str, str]:
        """Headers of each request."""
        return {"authorization": f"Bearer {self.key}"} if self.key else {}

    def ask(self, method: str, path: str, **options: Any) -> Any:
        """JSON answer to a request.

        Parameters
        ----------
        method, path : str
        **options
            Of `httpx.request`.

        Returns
        -------
        object

        Raises
        ------
        ServiceFailed
        """
        headers = self.headers | options.pop("headers", {})
        try:
            response = httpx.request(method, self.url + path, timeout=_ANSWER_SECONDS, headers=headers, **options)
        except httpx.HTTPError as error:
            message = f"no service answers at {self.url} ({error}); start one with `rattle serve`, or name another"
            raise ServiceFailed(message) from error
        if response.is_error:
            raise ServiceFailed(detail_of(response), response.status_code)
        return response.json() if response.content else None

    def submit(self, job: Any) -> RemoteJob:
        """Submit a job. The same request again is the same job.

        Parameters
        ----------
        job : Job or dict
            A request as JSON needs no canonical form; its kind is read from it.

        Returns
        -------
        RemoteJob

        Raises
        ------
        ServiceFailed
            If the service refuses it, or does not answer.
        """
        request = job if isinstance(job, dict) else job.request()
        return self.submit_text(json.dumps(request))

    def submit_text(self, body: str) -> RemoteJob:
        """Submit the text of a request; the service says what is wrong with it."""
        path, headers = f"/v1/{path_of(body)}", {"content-type": "application/json"}
        return RemoteJob(self, self.ask("POST", path, content=body, headers=headers))

    def job(self, job_id: str) -> RemoteJob:
        """The job with an id.

        Raises
        ------
        ServiceFailed
            If there is none.
        """
        return RemoteJob(self, self.ask("GET", f"/v1/jobs/{job_id}"))

    def jobs(self, limit: int = 20) -> list[RemoteJob]:
        """The newest jobs.

        Parameters
        ----------
        limit : int
            How many at most.

        Returns
        -------
        list of RemoteJob
            Newest first.

        Raises
        ------
        ServiceFailed
        """
        return [RemoteJob(self, each) for each in self.ask("GET", f"/v1/jobs?size={limit}")["jobs"]]


def path_of(body: str) -> str:
    """Path of a request's route: that of the kind it names, else of a sweep if it varies something, else of a basin."""
    try:
        request: Any = json.loads(body)
    except ValueError:
        request = {}
    request = request if isinstance(request, dict) else {}
    unnamed = KINDS["sweep" if "vary" in request else "basin"]
    return KINDS.get(str(request.get("kind")), unnamed).path
