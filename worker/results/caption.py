"""What a picture shows, in a few sentences that can stand below it: parameters, window, and what to cite."""

import json

import xarray as xr

from worker.jobs.basin_job import BasinJob
from worker.jobs.design import SweepAxis
from worker.jobs.job import Job
from worker.kinds import KINDS, kind_of
from worker.pictures.symbols import axis_in_words, oscillator_text, value_in_words
from worker.pictures.window import whole_window
from worker.results.panel import USUAL_LOOK, Layer, Look
from worker.stores.provenance import REFERENCES

_LAYERS = {
    Layer.SOLUTION: "Colours are the motions that departures end in.",
    Layer.GROUP: "Colours are Hsu's groups: which cycle of cells is reached.",
    Layer.PERIOD: "Colours are Hsu's periods: how long the cycle of cells is.",
    Layer.STEP: "Colours are Hsu's steps: how soon the cycle of cells is reached.",
    Layer.LOUDNESS: "Colours are the impact power of the motions that departures end in.",
}


def caption_of(dataset: xr.Dataset, look: Look = USUAL_LOOK) -> str:
    """Caption of a picture of a result of any kind.

    Parameters
    ----------
    dataset : xarray.Dataset
    look : Look
        How basins are drawn.

    Returns
    -------
    str

    Examples
    --------
    >>> import rattle
    >>> caption_of(rattle.basin(cells=40, progress=False)).split(". ")[1]
    'Departures at time t from 0 to 1 with velocity v from 0 to 7, 40 x 40 cells, k = 1499'
    """
    attributes = dataset.attrs
    request = json.loads(attributes["request"])
    job: Job = KINDS[kind_of(request)].job_class.from_request(request)
    sentences = [f"{attributes['title']}: {_parameters(job, look)}."]
    if isinstance(job, BasinJob):
        sentences += [_window(job, look), _LAYERS[look.layer]]
    if not attributes.get("complete", True):
        sentences.append("Incomplete.")
    computed = f"Computed with {attributes['source']}, request {attributes['request_sha256'][:16]}."
    return " ".join([*sentences, computed, f"{attributes.get('references', REFERENCES)}."])


def _parameters(job: Job, look: Look) -> str:
    if isinstance(job, BasinJob) and job.axes and look.panel is not None:
        steps = zip(job.axes, job.place_of(look.panel), strict=True)
        designed = [value_in_words(axis, at) for axis, at in steps if axis.name not in axis.columns]
        return ", ".join([oscillator_text(job.oscillator_of(look.panel)), *designed])
    swept = tuple(name for axis in job.axes for name in axis.columns)
    return ", ".join([oscillator_text(job.oscillator, without=swept), *map(_range, job.axes)])


def _range(axis: SweepAxis) -> str:
    return f"{axis_in_words(axis)} from {axis.values[0]:g} to {axis.values[-1]:g}"


def _window(job: BasinJob, look: Look) -> str:
    window, grid = look.window or whole_window(job.grid), job.grid
    cells = f"{job.sample.points} points" if job.sample else f"{grid.time_cells} x {grid.velocity_cells} cells"
    if look.window is not None and look.window != whole_window(grid):
        cells += f" over t from {grid.time_start:g} to {grid.time_stop:g}, v from {grid.velocity_start:g} to "
        cells += f"{grid.velocity_stop:g}"
    return (
        f"Departures at time t from {window.time_start:.9g} to {window.time_stop:.9g} with velocity v from "
        f"{window.velocity_start:.9g} to {window.velocity_stop:.9g}, {cells}, k = {job.iterations}."
    )
