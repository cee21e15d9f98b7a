"""`rattle.connect`: the same verbs computed by a service give the same datasets."""

import inspect

import httpx2 as httpx
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from typer.testing import CliRunner

import rattle
from rattle.cli import app
from rattle.verbs import VERBS
from service.records.keys import Keys, KeyScope
from tests.service.idle_service import idle_service
from worker.jobs.basin_job import basin_job
from worker.results.figure import basin_figure
from worker.stores.new_store import create_store

SWEEP = {
    "grid": {"time": {"cells": 12}, "velocity": {"cells": 12}}, "iterations": 61,
    "vary": [{"parameter": "damping", "values": [0.58, 0.6]}],
}  # fmt: skip


@pytest.fixture(scope="module")
def there(service):
    return rattle.connect(service.url)


def test_the_same_question_has_the_same_answer_there(there, basin):
    remote = there.basin(cells=40, progress=False)
    for name in basin.variables:
        np.testing.assert_array_equal(remote[name].values, basin[name].values, err_msg=str(name))
    assert remote.attrs["request_sha256"] == basin.attrs["request_sha256"]
    assert remote.rattle.plot(overlays=[]).images


def test_it_has_the_verbs_of_the_package_with_the_same_arguments(there):
    required = {"manifolds": {"saddles": "P(1,1,0)"}, "trajectory": {"velocity": 3.0}}
    for name in (*(verb.__name__ for verb in VERBS.values()), "trajectory"):
        assert inspect.signature(getattr(there, name)) == inspect.signature(getattr(rattle, name))
        with pytest.raises(TypeError, match="unexpected keyword argument 'dampign'"):
            getattr(there, name)(dampign=0.6, **required.get(name, {}))
    for given in ({"store": "here.zarr"}, {"workers": 2}, {"scheduler": "tcp://127.0.0.1:8786"}):
        with pytest.raises(TypeError, match="of a service takes no .*, which is of work here"):
            there.basin(**given)


@pytest.mark.slow
def test_a_result_of_a_machine_has_its_units_wherever_it_is_opened(there):
    # The paper's scaled numbers at 100 rad/s: delta = 2 pi T/(I Omega^2).
    pair = rattle.GearPair(
        speed=100.0, inertia=0.01, drag_torque=300 / np.pi, base_radius=0.1, backlash=0.12, transmission_error=0.01
    )
    given = {"cells": 12, "iterations": 101, "progress": False}
    here = rattle.basin(pair, **given)
    xr.testing.assert_equal(there.basin(pair, **given).load(), here.load())
    speeds = there.sweep(pair, speed=["900 rpm", "950 rpm"], **given)
    assert speeds.rattle.machines == tuple(pair.at_speed(speed) for speed in ("900 rpm", "950 rpm"))
    job = there.submit(here.rattle.job).wait(progress=False)
    assert rattle.open(job.url).rattle.machine == pair
    table = httpx.get(job.url.removesuffix(".zarr") + ".csv", params={"units": "si"}).text.splitlines()[0].split(",")
    assert "impact_power_w" in table and "impact_power" not in table


def test_a_trajectory_is_that_of_here(there):
    given = {"damping": 0.6, "stiffness": 100.0, "velocity": 4.0, "periods": 3.0}
    xr.testing.assert_equal(there.trajectory(**given), rattle.trajectory(**given))


def test_a_job_is_submitted_followed_listed_and_deleted(there, service):
    job = there.submit(rattle.BasinJob.from_request({"grid": {"time": {"cells": 12}, "velocity": {"cells": 12}}}))
    assert job.kind == "basin" and job.wait(progress=False).state == "succeeded"
    assert job.progress["tiles_done"] == job.progress["tiles_total"]
    assert job.id in [each.id for each in there.jobs()] and there.job(job.id).id == job.id
    assert job.result()["complete"] and job.open().rattle.complete
    assert rattle.open(job.url).rattle.kind == "basin"
    assert job.id in repr(job) and job.cancel().state == "succeeded"
    job.delete()
    with pytest.raises(rattle.ServiceFailed, match="there is no job"):
        there.job(job.id)


@pytest.mark.slow
def test_the_shell_draws_and_lists_what_lies_at_an_address(there, tmp_path):
    job = there.submit(rattle.SweepJob.from_request(SWEEP)).wait(progress=False)
    shell, picture = CliRunner(), tmp_path / "sweep.png"
    for more in ([], ["--shares"], ["--overlay", "attractors"], ["--layer", "group"]):
        assert shell.invoke(app, ["plot", job.url, "--out", str(picture), *more]).exit_code == 0
        assert picture.read_bytes().startswith(b"\x89PNG")
    listed = shell.invoke(app, ["table", job.url])
    assert listed.exit_code == 0 and "permanent contact" in listed.output
    nowhere = shell.invoke(app, ["plot", "http://127.0.0.1:9/result.zarr", "--out", str(picture)])
    assert nowhere.exit_code == 1 and "127.0.0.1:9" in nowhere.output


def test_a_result_is_fetched_to_the_byte(there, service, tmp_path):
    job = there.submit(rattle.SweepJob.from_request(SWEEP)).wait(progress=False)
    own = tmp_path / "sweep.zarr"
    fetched = job.fetch(own, progress=False)
    assert fetched.rattle.complete and basin_figure(str(own)) is not None
    theirs = service.data / "results" / f"{job.id}.zarr"
    assert {str(path.relative_to(own)): path.read_bytes() for path in own.rglob("*") if path.is_file()} == {
        str(path.relative_to(theirs)): path.read_bytes() for path in theirs.rglob("*") if path.is_file()
    }
    with pytest.raises(rattle.StoreConflict, match="is there already"):
        job.fetch(own)
    arguments = ["fetch", job.id[:8], "--url", service.url, "--out"]
    assert CliRunner().invoke(app, [*arguments, str(tmp_path / "again.zarr")]).exit_code == 0
    assert CliRunner().invoke(app, [*arguments, str(own)]).exit_code == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["again.zarr", "sweep.zarr"], "no part is left"


def test_a_job_that_has_not_ended_cannot_be_fetched(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path / "data") as service:
        job = rattle.connect(service.url).job(service.add_job().id)
        with pytest.raises(rattle.ServiceFailed, match="is queued: fetch its result once it has ended"):
            job.fetch(tmp_path / "early.zarr")
        with pytest.raises(rattle.ServiceFailed, match="there is no store"):
            job.cancel().fetch(tmp_path / "early.zarr")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["data"]


def test_an_address_that_wants_a_key_says_so(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path, require_keys=True) as service:
        job = service.add_job()
        create_store(f"{service.results}/{job.id}.zarr", basin_job(job.request))
        key = Keys(service.jobs._sessions).add("me", [KeyScope.READ])
        address = f"{service.url}/v1/jobs/{job.id}/result.zarr"
        for wrong in (None, "wrong"):
            with pytest.raises(PermissionError, match="answered 401 Unauthorized: give a key of the service"):
                rattle.open(address, key=wrong)
        assert rattle.open(address, key=key).rattle.kind == "basin"


def test_what_a_service_refuses_is_said_in_its_words(there, service):
    with pytest.raises(ValueError, match="epsilon_crit1"):
        there.basin(eccentricity=0.3, stiffness=1e4)
    with pytest.raises(rattle.ServiceFailed, match="RATTLE_MAX_ORDER"):
        there.grazing_curve(order=17)
    with pytest.raises(rattle.ServiceFailed, match="no service answers"):
        rattle.connect("http://127.0.0.1:9")


def test_tables_are_served_as_csv_and_json(there, service):
    job = there.submit({"kind": "grazing_curve", "order": 1}).wait(progress=False)
    here = rattle.grazing_curve(order=1, progress=False).rattle.to_table()
    csv = httpx.get(f"{service.url}/v1/jobs/{job.id}/result.csv")
    assert csv.headers["content-type"].startswith("text/csv")
    assert csv.text.splitlines()[0] == ",".join(here.columns)
    rows = httpx.get(f"{service.url}/v1/jobs/{job.id}/result.json").json()
    pd.testing.assert_frame_equal(pd.DataFrame(rows), here, check_dtype=False)
    again = httpx.get(f"{service.url}/v1/jobs/{job.id}/result.csv", headers={"if-none-match": csv.headers["etag"]})
    assert again.status_code == 304
    refused = httpx.get(f"{service.url}/v1/jobs/{job.id}/result.csv?table=x")
    assert refused.status_code == 422 and "there are order" in refused.json()["detail"]


@pytest.mark.parametrize(("ending", "first"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_pictures_are_served_in_three_formats(there, service, ending, first):
    job = there.submit({"kind": "grazing_curve", "order": 1}).wait(progress=False)
    answer = httpx.get(f"{service.url}/v1/jobs/{job.id}/picture.{ending}")
    assert answer.status_code == 200 and answer.content.startswith(first)
