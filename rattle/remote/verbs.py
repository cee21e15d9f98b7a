"""The verbs of a service: the same arguments and results as here, computed there."""

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from rattle.argument import Argument
from rattle.arguments import demand_known, demand_names, job_of
from rattle.remote.client import ServiceClient
from rattle.results.trajectories import TRAJECTORY_EXAMPLE, dataset_of, trajectory_arguments, trajectory_request
from rattle.verb import VERBS, Verb, described
from rattle_kernels import Contacts, Direction, Outcome, TimeHistory
from worker.kinds import KINDS

_PROGRESS = Argument("progress", bool, True, "Whether progress is shown on a terminal and in a notebook")
_OUTCOMES = {
    "rattling": Outcome.RETURNED, "permanent_contact": Outcome.PERMANENT_CONTACT, "undecided": Outcome.NOT_CONVERGED,
}  # fmt: skip


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


class Service(ServiceClient):
    """A service: its verbs are those of this package, and compute there.

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

    def __init__(self, url: str, key: str | None = None) -> None:
        super().__init__(url, key)
        self.basin, self.sweep, self.bifurcation, self.orbits, self.manifolds, self.grazing_curve = (
            _verb(self, verb) for verb in VERBS
        )
        self.trajectory = _trajectory(self)


def _verb(service: ServiceClient, verb: Verb) -> Callable[..., xr.Dataset]:
    arguments = (*verb.arguments, _PROGRESS)

    def call(*positional: Any, progress: bool = True, **given: Any) -> xr.Dataset:
        demand_names(verb.name, positional, verb.arguments)
        demand_known(verb.name, given, [each.name for each in arguments])
        job = service.submit(job_of(KINDS[verb.kind].job_class, given, verb.name))
        job.wait(progress).demand_success()
        return job.open()

    return described(call, verb.name, verb.summary, arguments, verb.returns, verb.example)


def _trajectory(service: ServiceClient) -> Callable[..., xr.Dataset]:
    def call(*positional: Any, **given: Any) -> xr.Dataset:
        demand_names("trajectory", positional, trajectory_arguments())
        request = trajectory_request(given)
        answer = service.ask("POST", "/v1/trajectories", json=request.model_dump(mode="json", exclude_unset=True))
        return dataset_of(request, _history_of(answer))

    return described(call, "trajectory", TRAJECTORY_EXAMPLE[0], trajectory_arguments(), *TRAJECTORY_EXAMPLE[1:])


def _history_of(answer: dict[str, Any]) -> TimeHistory:
    """Time history as the service answers it."""
    rows = answer["contacts"]
    contacts = Contacts(
        np.array([row["time"] for row in rows]), np.array([row["wall"] for row in rows], np.int8),
        np.array([Direction[row["direction"].upper()] for row in rows], np.int8),
        np.array([row["speed"] for row in rows]),
    )  # fmt: skip
    time, displacement, velocity = (np.array(answer[name]) for name in ("time", "displacement", "velocity"))
    permanent_from = np.inf if answer["permanent_from"] is None else answer["permanent_from"]
    return TimeHistory(
        time, displacement, velocity, contacts, _OUTCOMES[answer["outcome"]], answer["truncated"], permanent_from
    )
