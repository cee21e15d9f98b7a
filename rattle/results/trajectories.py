"""One time history as a dataset, and back."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from pydantic import ValidationError

from rattle.argument import Argument
from rattle.arguments import demand_given
from rattle.oscillator_arguments import oscillator_group
from rattle_kernels import Contacts, Oscillator, Outcome, TimeHistory
from worker.jobs.request import refusal
from worker.jobs.trajectory_request import StartRequest, TrajectoryRequest

TRAJECTORY = "trajectory"
"""Kind of such a dataset."""

TRAJECTORY_EXAMPLE = (
    "Follow one motion of either model.",
    "``displacement`` and ``velocity`` over ``time``; contacts along ``contact``.",
    ">>> motion = rattle.trajectory(damping=0.6, stiffness=1000.0, velocity=4.0, periods=5.0)\n"
    ">>> float(motion.time[-1])\n5.0",
)
"""What the verb does, what comes back, and an example."""


def trajectory_arguments() -> tuple[Argument, ...]:
    """Arguments of the verb: an oscillator, where it starts, and for how long it is followed."""
    start, whole = StartRequest.model_fields, TrajectoryRequest.model_fields
    named: list[tuple[str, Any, Any]] = [
        ("time", float, start),
        ("velocity", float, start),
        ("displacement", float | None, start),
    ]
    named += [("periods", float, whole), ("samples_per_period", int, whole)]
    own = []
    for name, kind, fields in named:
        default = ... if fields[name].is_required() else fields[name].default
        own.append(Argument(name, kind, default, fields[name].description or ""))
    return (*oscillator_group().arguments, *own)


def trajectory_request(given: Mapping[str, Any]) -> TrajectoryRequest:
    """Request that arguments make.

    Parameters
    ----------
    given : dict
        Only the arguments that were given.

    Returns
    -------
    TrajectoryRequest

    Raises
    ------
    TypeError
        If an argument is unknown or missing.
    InvalidJob
        If a value has a wrong type or lies out of range.
    """
    demand_given("trajectory", given, trajectory_arguments())
    start = {name: given[name] for name in ("time", "velocity", "displacement") if given.get(name) is not None}
    rest = {name: given[name] for name in ("periods", "samples_per_period") if name in given}
    try:
        return TrajectoryRequest(oscillator=oscillator_group().read(given), start=start, **rest)
    except ValidationError as error:
        raise refusal(error) from error


def dataset_of(request: TrajectoryRequest, history: TimeHistory) -> xr.Dataset:
    """Dataset of a time history.

    Parameters
    ----------
    request : TrajectoryRequest
    history : TimeHistory

    Returns
    -------
    xarray.Dataset
        ``displacement`` and ``velocity`` over ``time`` (forcing periods, not reduced; an impact is two samples at one
        time), and the contacts over ``contact``.
    """
    contacts = {f"contact_{name}": ("contact", values) for name, values in history.contacts._asdict().items()}
    body = {"kind": TRAJECTORY} | request.model_dump(mode="json", exclude_none=True)
    attributes = {
        "title": "time history of a rattling gear pair", "request": json.dumps(body),
        "outcome": Outcome(history.outcome).name.lower(), "truncated": int(history.truncated),
        "permanent_from": float(history.permanent_from),
    }  # fmt: skip
    return xr.Dataset(
        {"displacement": ("time", history.displacement), "velocity": ("time", history.velocity)} | contacts,
        {"time": ("time", history.time, {"units": "1", "comment": "forcing periods"})},
        attributes,
    )


def history_of(dataset: xr.Dataset) -> tuple[Oscillator, TimeHistory]:
    """Oscillator and time history of a dataset.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of `dataset_of`.

    Returns
    -------
    Oscillator, TimeHistory
    """
    request: dict[str, Any] = json.loads(dataset.attrs["request"])
    del request["kind"]
    oscillator = TrajectoryRequest.model_validate(request).oscillator.to_oscillator()
    contacts = Contacts(*(np.asarray(dataset[f"contact_{name}"].values) for name in Contacts._fields))
    history = TimeHistory(
        dataset.time.values, dataset.displacement.values, dataset.velocity.values, contacts,
        Outcome[dataset.attrs["outcome"].upper()], bool(dataset.attrs["truncated"]), dataset.attrs["permanent_from"],
    )  # fmt: skip
    return oscillator, history
