"""What a result says of itself: the request that it answers, its kind, and whether all of it is there."""

import json
from functools import cached_property
from typing import Any

import xarray as xr

from rattle.results.trajectories import TRAJECTORY, history_of
from rattle_kernels import Oscillator
from worker.errors import InvalidJob
from worker.jobs.job import Job
from worker.kinds import KINDS


class Described:
    """A dataset of this project, with its request.

    Parameters
    ----------
    dataset : xarray.Dataset
    """

    def __init__(self, dataset: xr.Dataset) -> None:
        if "request" not in dataset.attrs:
            raise InvalidJob("this dataset is no result of this project: it has no attribute `request`")
        self._dataset = dataset

    def __repr__(self) -> str:
        state = "complete" if self.complete else "incomplete"
        return f"<{self.kind} of {self.oscillator}, {state}>"

    @property
    def request(self) -> dict[str, Any]:
        """Request that the result answers, as JSON.

        Examples
        --------
        >>> rattle.basin(cells=40, progress=False).rattle.request["iterations"]
        1499
        """
        request: dict[str, Any] = json.loads(self._dataset.attrs["request"])
        return request

    @property
    def kind(self) -> str:
        """Kind of the job: basin, sweep, bifurcation, orbits, manifold, grazing_curve, or trajectory.

        Examples
        --------
        >>> rattle.grazing_curve(order=0, progress=False).rattle.kind
        'grazing_curve'
        """
        request = self.request
        return str(request.get("kind") or ("sweep" if "vary" in request else "basin"))

    @property
    def complete(self) -> bool:
        """Whether all of it is there.

        Examples
        --------
        >>> rattle.basin(cells=40, progress=False).rattle.complete
        True
        """
        return bool(self._dataset.attrs.get("complete", True))

    @cached_property
    def job(self) -> Job:
        """The job whose result this is; a trajectory is of no job, since it is computed at once.

        Examples
        --------
        >>> basin = rattle.basin(cells=40, progress=False)
        >>> basin.rattle.job.grid.velocity_stop
        7.0
        """
        if self.kind == TRAJECTORY:
            raise InvalidJob("a trajectory is no job: it is computed at once")
        return KINDS[self.kind].job_class.from_request(self.request)

    @property
    def oscillator(self) -> Oscillator:
        """Oscillator; of a sweep or a diagram, at the first value.

        Examples
        --------
        >>> rattle.basin(damping=0.7, cells=10, progress=False).rattle.oscillator.damping
        0.7
        """
        return history_of(self._dataset)[0] if self.kind == TRAJECTORY else self.job.oscillator

    def _demand(self, what: str, *kinds: str) -> None:
        if self.kind not in kinds:
            raise InvalidJob(f"a result of kind {self.kind} has no {what}; those of kind {' and '.join(kinds)} have")
