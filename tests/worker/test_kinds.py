"""A fifth analysis takes a job, an `Analysis` and one entry: its route, its command and its picture follow."""

import json
import threading
from typing import Annotated, Any, Literal

import numpy as np
import pytest
import xarray as xr
from pydantic import Field
from typer.testing import CliRunner

from rattle.cli import command_line
from rattle_kernels import grazing_velocity
from service.openapi import document
from tests.service.idle_service import idle_service
from worker.analyses.analysis import Analysis, Piece, ready_of
from worker.cluster.driver import Driver
from worker.fence import unfenced
from worker.jobs.job import AnalysisJob
from worker.kinds import KINDS, JobKind
from worker.progress import Stage
from worker.storage.location import result_location
from worker.stores.layout import Variable


class GrazingSpeedJob(AnalysisJob):
    """The grazing speed v* at some phases."""

    kind_: Literal["grazing_speed"] = "grazing_speed"
    phases: Annotated[int, Field(strict=True, ge=1)] = Field(8, description="Number of phases")

    @property
    def fastest(self):
        """No speed is asked for."""
        return 0.0

    def sizes(self):
        """What is large about the request."""
        return (("phases", self.phases, "max_order"),)

    @property
    def impacts(self):
        """A flight a phase."""
        return self.phases

    @property
    def bytes(self):
        """A speed a phase."""
        return 8 * self.phases

    def _settled(self) -> dict[str, Any]:
        return {"kind_": self.kind_, "phases": self.phases}


def speeds(oscillator, phases, *, pause):
    """Compute them."""
    return {"speed": grazing_velocity(oscillator, np.arange(phases) / phases)}


def plan(job, parts):
    """One piece."""
    return ready_of(Stage.SEARCHING, [Piece("speeds", speeds, (job.oscillator, job.phases))], parts)


GRAZING_SPEED = Analysis(
    "Grazing speeds of a rattling gear pair",
    GrazingSpeedJob.from_request,
    plan,
    lambda job, parts: parts["speeds"] if "speeds" in parts else {"speed": np.empty(0)},
    lambda job: (Variable("speed", ("phase",), np.float64, np.inf, "v*"),),
    lambda job, columns: {"largest": float(columns["speed"].max(initial=0.0))},
    lambda job, columns, figure: figure.subplots().plot(columns["speed"]),
)


@pytest.fixture
def fifth(monkeypatch):
    entry = JobKind(
        path="grazing-speeds", summary="Submit grazing speeds", description="Compute v*.", command="Compute v*.",
        job=f"{__name__}:GrazingSpeedJob", analysis=f"{__name__}:GRAZING_SPEED",
    )  # fmt: skip
    monkeypatch.setitem(KINDS, "grazing_speed", entry)
    entry.__dict__.update(job_class=GrazingSpeedJob, loaded_analysis=GRAZING_SPEED)
    return entry


def test_a_fifth_kind_is_run_over_http(fifth, client, monkeypatch, tmp_path):
    schema = document()
    body = schema["paths"]["/v1/grazing-speeds"]["post"]["requestBody"]["content"]["application/json"]["schema"]
    assert body["$ref"].endswith("GrazingSpeedJob") and "GrazingSpeedJob" in schema["components"]["schemas"]
    with idle_service(monkeypatch, tmp_path) as service:
        refused = service.request("POST", "/v1/grazing-speeds", json={"phases": 0})
        assert refused.status_code == 422 and refused.json()["errors"][0]["location"] == ["body", "phases"]
        large = service.request("POST", "/v1/grazing-speeds", json={"phases": 17})
        assert large.status_code == 422 and "RATTLE_MAX_ORDER" in large.json()["detail"]
        job = service.request("POST", "/v1/grazing-speeds", json={"phases": 4}).json()
        assert job["kind"] == "grazing_speed" and job["request"]["phases"] == 4
        record = service.jobs.get(job["id"])
        location = result_location(service.results, record.store or record.id)
        run_it = KINDS[record.kind].run
        asked = KINDS[record.kind].job_class.from_request(record.request)
        run_it(asked, location, Driver(client), report=lambda _: None, cancel=threading.Event(), fence=unfenced)
        result = service.request("GET", job["links"]["result"]).json()
        assert result["complete"] and result["kind"] == "grazing_speed" and result["largest"] > 0.0
        assert service.request("GET", job["links"]["picture"]).content.startswith(b"\x89PNG")


def test_a_fifth_kind_is_run_from_the_command_line(fifth, tmp_path):
    helped = CliRunner().invoke(command_line(), ["grazing-speed", "--help"])
    assert "--phases" in helped.output and "Number of phases" in helped.output and "--damping" in helped.output
    store = tmp_path / "store"
    done = CliRunner().invoke(command_line(), ["grazing-speed", "--phases", "4", "--out", str(store)])
    assert done.exit_code == 0, done.output
    assert '"largest"' in done.output
    with xr.open_zarr(store) as speed:
        assert speed.speed.dims == ("phase",) and json.loads(speed.attrs["request"])["phases"] == 4
