"""A service elsewhere: its jobs, and the verbs that it computes. Neither Numba nor Dask is loaded to ask it."""

import functools
import inspect
import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, ParamSpec

import httpx2 as httpx

from rattle import verbs
from rattle.remote.failure import ServiceFailed, detail_of
from rattle.remote.job import RemoteJob
from worker.kinds import KINDS, kind_of

if TYPE_CHECKING:
    import xarray as xr

    from rattle_kernels import TimeHistory

_P = ParamSpec("_P")
_ANSWER_SECONDS = 30.0
_OF_WORK_HERE = ("store", "workers", "scheduler")


def connect(url: str, key: str | None = None) -> "Service":
    """Connect to a service.

    Parameters
    ----------
    url : str
        Its address, as in ``http://127.0.0.1:8000``.
    key : str, optional
        If the service requires one.

    Returns
    -------
    Service
        It has the verbs of this package.

    Raises
    ------
    ServiceFailed
        If no service answers there.

    Examples
    --------
    >>> import rattle
    >>> there = rattle.connect("http://127.0.0.1:8000")
    >>> there.basin(cells=20, progress=False).name.values.tolist()
    ['permanent contact', 'P(1,1,0)', 'chaotic']
    """
    service = Service(url, key)
    service.ask("GET", "/healthz")
    return service


class _There(Generic[_P]):
    """A verb of this package as a method of a service: with the same arguments, for type checkers as well."""

    def __init__(self, verb: "Callable[_P, xr.Dataset]", ask: "Callable[[Service, str, dict[str, Any]], xr.Dataset]"):
        self.verb, self.ask = verb, ask

    def __get__(self, service: "Service | None", owner: type) -> "Callable[_P, xr.Dataset]":
        if service is None:
            return self.verb

        @functools.wraps(self.verb)
        def call(*args: _P.args, **kwargs: _P.kwargs) -> "xr.Dataset":
            signature = inspect.signature(self.verb)
            signature.bind(*args, **kwargs)
            given = dict(zip(signature.parameters, args, strict=False)) | kwargs
            for name in _OF_WORK_HERE:
                if given.get(name) is not None:
                    raise TypeError(f"{self.verb.__name__}() of a service takes no {name}, which is of work here")
            return self.ask(service, self.verb.__name__, verbs.given_of(self.verb, given))

        return call


def _computed(service: "Service", name: str, given: dict[str, Any]) -> "xr.Dataset":
    """Let the service compute the job that arguments describe, and open its result."""
    from rattle.arguments import job_of

    progress = given.pop("progress", True)
    if callable(progress):
        raise TypeError(f"{name}() of a service shows its progress or does not: give progress=True or False")
    (kind,) = (kind for kind, verb in verbs.VERBS.items() if verb.__name__ == name)
    job = service.submit(job_of(kind, given))
    job.wait(progress).demand_success()
    return job.open()


def _followed(service: "Service", _: str, given: dict[str, Any]) -> "xr.Dataset":
    """Let the service follow a motion."""
    from rattle.arguments import read_machine, trajectory_of
    from rattle.results.trajectories import dataset_of

    machine = read_machine(given)
    request = trajectory_of(given)
    answer = service.ask("POST", "/v1/trajectories", json=request.model_dump(mode="json", exclude_unset=True))
    result = dataset_of(request, _history_of(answer))
    return result if machine is None else machine.with_units(result)


def _history_of(answer: dict[str, Any]) -> "TimeHistory":
    """Time history as the service answers it."""
    import numpy as np

    from rattle_kernels import Contacts, Direction, Outcome, TimeHistory

    outcomes = {
        "rattling": Outcome.RETURNED, "permanent_contact": Outcome.PERMANENT_CONTACT,
        "undecided": Outcome.NOT_CONVERGED,
    }  # fmt: skip
    rows = answer["contacts"]
    contacts = Contacts(
        np.array([row["time"] for row in rows]), np.array([row["wall"] for row in rows], np.int8),
        np.array([Direction[row["direction"].upper()] for row in rows], np.int8),
        np.array([row["speed"] for row in rows]),
    )  # fmt: skip
    time, displacement, velocity = (np.array(answer[name]) for name in ("time", "displacement", "velocity"))
    permanent_from = np.inf if answer["permanent_from"] is None else answer["permanent_from"]
    return TimeHistory(
        time, displacement, velocity, contacts, outcomes[answer["outcome"]], answer["truncated"], permanent_from
    )


class Service:
    """A service: its verbs are those of this package, and compute there.

    Arguments that are about work here, ``store``, ``workers`` and ``scheduler``, are refused.

    Parameters
    ----------
    url : str
    key : str, optional

    Examples
    --------
    >>> import rattle
    >>> there = rattle.connect("http://127.0.0.1:8000")
    >>> there.grazing_curve(order=1, progress=False).sizes["order"]
    2
    >>> job = there.submit(rattle.GrazingCurveJob(order=1))  # the same request is the same job
    >>> job.id in [each.id for each in there.jobs()]
    True
    """

    basin = _There(verbs.basin, _computed)
    sweep = _There(verbs.sweep, _computed)
    bifurcation = _There(verbs.bifurcation, _computed)
    orbits = _There(verbs.orbits, _computed)
    manifolds = _There(verbs.manifolds, _computed)
    grazing_curve = _There(verbs.grazing_curve, _computed)
    trajectory = _There(verbs.trajectory, _followed)

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
            Of ``httpx.request``.

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
    if str(request.get("kind")) not in KINDS:  # the route says what is wrong with it
        request.pop("kind", None)
    return KINDS[str(kind_of(request))].path
