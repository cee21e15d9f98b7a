"""One time history as a dataset, and back."""

import json
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from rattle_kernels import Contacts, Oscillator, Outcome, TimeHistory
from worker.jobs.trajectory_request import TrajectoryRequest
from worker.kinds import ResultKind

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TRAJECTORY = "trajectory"
"""Kind of such a dataset."""
_SIZE = 11.0, 4.5


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
    oscillator = TrajectoryRequest.model_validate(request).oscillator.value
    contacts = Contacts(*(np.asarray(dataset[f"contact_{name}"].values) for name in Contacts._fields))
    history = TimeHistory(
        dataset.time.values, dataset.displacement.values, dataset.velocity.values, contacts,
        Outcome[dataset.attrs["outcome"].upper()], bool(dataset.attrs["truncated"]), dataset.attrs["permanent_from"],
    )  # fmt: skip
    return oscillator, history


def _draw(dataset: xr.Dataset, figure: "Figure", look: object = None) -> None:
    from worker.pictures.history import draw_history  # loads Matplotlib

    figure.set_size_inches(_SIZE)
    draw_history(figure, *history_of(dataset))


TRAJECTORY_RESULT = ResultKind(name=TRAJECTORY, draw=_draw)
"""How such a dataset is drawn."""
