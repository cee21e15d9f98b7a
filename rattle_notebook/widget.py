"""The widget: the page in a frame, whose requests are messages, and whose view is a few traits."""

import math
from pathlib import Path
from typing import Any

import anywidget
import traitlets
import xarray as xr

import rattle
from rattle.arguments import job_of
from rattle_kernels import Oscillator
from rattle_notebook.in_process import in_process
from worker.errors import InvalidJob
from worker.gear_pair import GearPair
from worker.jobs.basin_job import BasinJob
from worker.kinds import KINDS
from worker.precision_limits import fastest_of
from worker.stores.opening import is_complete

_CELLS = 250


class Explorer(anywidget.AnyWidget):
    """The explorer in an output of a notebook. Its traits say what is seen; one that is set is shown.

    Attributes
    ----------
    oscillator : Oscillator or None
        None for what has no oscillator of its own.
    window : tuple of float or None
        (t0, t1, v0, v1): times in forcing periods, and velocities.
    departure : tuple of float or None
        (t, v) of the motion that is followed.
    solution : str or None
        Name of the motion that is highlighted.
    address : str
        All of the view, as the page's address has it.
    job : str or None
        Id of the job that is seen.
    history : list of str
        Lines of Python, one for each action on the page. Run in this order on another explorer called ``widget``, they
        lead to the same view.

    Notes
    -----
    Before the widget is displayed nobody computes, and its traits are what was set.
    """

    _esm = Path(__file__).with_name("frame.js")
    _opening = traitlets.Dict().tag(sync=True)
    _oscillator: Any = traitlets.Dict(allow_none=True, default_value=None).tag(sync=True)

    address = traitlets.Unicode("").tag(sync=True)
    oscillator = traitlets.Instance(Oscillator, allow_none=True)
    window = traitlets.Tuple(*4 * [traitlets.Float()], allow_none=True, default_value=None).tag(sync=True)
    departure = traitlets.Tuple(*2 * [traitlets.Float()], allow_none=True, default_value=None).tag(sync=True)
    solution = traitlets.Unicode(None, allow_none=True).tag(sync=True)
    job = traitlets.Unicode(None, allow_none=True).tag(sync=True)
    history = traitlets.List(traitlets.Unicode()).tag(sync=True)

    def __init__(self, opening: dict[str, Any]) -> None:
        super().__init__(_opening=opening)
        self._app = in_process()
        self.on_msg(self._answer)

    def compute(self) -> None:
        """Compute what is seen, as the button of the page does. Needs the widget to be displayed."""
        self.send({"compute": True})

    @property
    def result(self) -> xr.Dataset | None:
        """Result of the job that is seen, complete or not; None where none is. It is removed when the process ends."""
        return None if self.job is None else rattle.open(self._app.location_of(self.job))

    def _answer(self, _: Any, content: dict[str, Any], __: Any) -> None:
        answer = self._app.ask(content["method"], content["path"], content["headers"], content["body"])
        self.send({"id": content["id"], "status": answer.status, "headers": answer.headers}, [answer.body])

    @traitlets.validate("oscillator")
    def _checked_oscillator(self, proposal: Any) -> Oscillator | None:
        oscillator = proposal["value"]
        if oscillator is not None:
            BasinJob.check_oscillator(oscillator)
        return oscillator

    @traitlets.validate("window")
    def _checked_window(self, proposal: Any) -> tuple[float, ...] | None:
        window = proposal["value"]
        if window is not None and not (window[0] < window[1] and window[2] < window[3] and math.isfinite(sum(window))):
            raise traitlets.TraitError(f"a window is t0 < t1, v0 < v1, not {window}")
        return window

    @traitlets.observe("address")
    def _begun_anew(self, _: Any) -> None:
        # An address holds all of a view. Once a page tells what is seen, it tells its parts as well.
        if not self.history:
            for part in ("oscillator", "window", "departure", "solution"):
                setattr(self, part, None)

    @traitlets.observe("_oscillator")
    def _heard(self, change: Any) -> None:
        asked = change["new"]
        self.oscillator = None if asked is None else BasinJob.from_request({"oscillator": asked}).oscillator

    @traitlets.observe("oscillator")
    def _said(self, change: Any) -> None:
        oscillator = change["new"]
        asked = None if oscillator is None else BasinJob(oscillator=oscillator).request()["oscillator"]
        known = self._oscillator
        if asked is None or known is None or BasinJob.from_request({"oscillator": known}).oscillator != oscillator:
            self._oscillator = asked


def opening_of(what: xr.Dataset | Oscillator | GearPair | None) -> dict[str, Any]:
    """What the page shows first: a request, or a job with its request.

    Parameters
    ----------
    what : xarray.Dataset, Oscillator, GearPair or None

    Returns
    -------
    dict

    Raises
    ------
    InvalidJob
        If it cannot be shown.
    """
    if what is None:
        return {}
    if isinstance(what, Oscillator):
        velocity = {"start": 0.0, "stop": fastest_of(what), "cells": _CELLS}
        return {"request": BasinJob(oscillator=what, grid={"time": {"cells": _CELLS}, "velocity": velocity}).request()}
    if isinstance(what, GearPair):
        return {"request": job_of("basin", {"machine": what, "cells": _CELLS}).request()}
    if not isinstance(what, xr.Dataset):
        raise InvalidJob(f"explore() takes a result, an Oscillator or a GearPair, not {type(what).__name__}")
    return _opening_of_result(what)


def _opening_of_result(result: xr.Dataset) -> dict[str, Any]:
    kind = result.rattle.kind
    if kind not in KINDS:
        raise InvalidJob(f"a {kind} has no page of its own: explore its oscillator")
    request = result.rattle.request
    job = KINDS[kind].job_class.from_request(request)
    opening = {"request": request} if "grid" in request and "sample" not in request else {}
    location = result.encoding.get("source")
    if location is not None and Path(location).is_dir() and is_complete(location, job.digest):
        return opening | {"job": in_process().adopt(job, location)}
    if not opening:
        raise InvalidJob("this result is not in a folder here, complete: compute it with store=, or open it from one")
    return opening
