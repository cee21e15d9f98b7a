"""A report as a job: it goes on where it was left, and the same request is the same page, whoever computes it."""

import json
import threading

import pytest

import rattle
from rattle_machine.analysis import REPORT, page_in
from rattle_machine.job import ReportJob
from rattle_machine.report import report
from tests.analysis_requests import REPORT as ASKED
from tests.store_content import content
from worker.cluster.driver import Driver
from worker.errors import InvalidJob, JobCancelled
from worker.run import run_job
from worker.stores.analysis_store import PARTS

PAIR = rattle.GearPair(**ASKED["machine"])
HIT = {"rate": 0.0125, "size": 2.5 * PAIR.scales.impulse}
JOB = ReportJob(**ASKED, **HIT, title="Pump")
ALONE = {name: value for name, value in ASKED.items() if name != "machine"}


def run(client, location, report=lambda _: None, cancel=None):
    run_job(JOB, str(location), Driver(client), report=report, cancel=cancel or threading.Event())
    return REPORT.read(str(location))[1]


@pytest.fixture(scope="module")
def undisturbed(client, tmp_path_factory):
    """Its store, computed in one go by the workers of a cluster."""
    location = tmp_path_factory.mktemp("report") / "report.zarr"
    run(client, location)
    return location


@pytest.mark.slow
def test_its_page_is_the_one_that_the_package_writes(undisturbed, tmp_path):
    written = report(PAIR, tmp_path / "pump.html", title="Pump", prove=False, progress=False, **ALONE, **HIT)
    assert page_in(REPORT.read(str(undisturbed))[1]) == written.read_bytes()


@pytest.mark.slow
def test_its_result_says_first_what_the_page_says_first_and_what_happens_at_each_speed(undisturbed):
    told = REPORT.summary(str(undisturbed))
    text = page_in(REPORT.read(str(undisturbed))[1]).decode()
    assert told.complete and len(told.answers) == 3 and all(each in text for each in told.answers)
    swept = rattle.sweep(PAIR, speed=[each.speed for each in JOB.over.pairs], sample=64, progress=False)
    assert [each.speed for each in told.speeds] == [each.speed for each in swept.rattle.machines]
    assert [each.quiet_share for each in told.speeds] == swept.share.values[:, 0].tolist()
    # Written in rpm to nine digits.
    assert min(abs(each.speed / PAIR.speed - 1.0) for each in told.speeds) < 1e-8
    assert [each.gamma for each in told.speeds] == swept.gamma.values.tolist()
    power = swept.rattle.loudness().expected_impact_power_w.values.tolist()
    assert [each.impact_power_w for each in told.speeds] == power and max(power) > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("reports", [1, 3, 5, 8], ids="after {} reports".format)
def test_a_cancelled_report_goes_on_to_the_same_bytes(client, undisturbed, tmp_path, reports):
    cancel, seen, location = threading.Event(), [], tmp_path / "report.zarr"

    def cancel_soon(progress):
        seen.append(progress)
        if len(seen) == reports:
            cancel.set()

    with pytest.raises(JobCancelled):
        run(client, location, cancel_soon, cancel)
    partial = REPORT.summary(str(location))
    assert not partial.complete and partial.answers == [] and partial.speeds == []
    REPORT.figure(str(location))
    assert rattle.check(location).damages == ()
    run(client, location)
    assert content(location) == content(undisturbed)
    assert not (location / PARTS).exists(), "the basin and the sweep were for the page alone"


@pytest.mark.slow
def test_a_report_whose_page_is_damaged_is_mended(client, undisturbed, tmp_path):
    location = tmp_path / "report.zarr"
    run(client, location)
    (chunk,) = (location / "page" / "c").iterdir()
    chunk.write_bytes(chunk.read_bytes()[:-1])
    found = rattle.check(location)
    assert [each.array for each in found.damages] == ["page"] and found.mended
    assert content(location) == content(undisturbed)


def test_a_request_is_the_same_job_however_it_is_written():
    written = ASKED | {"machine": ASKED["machine"] | {"speed": "100 rad/s", "backlash": "120 mm"}}
    written |= {"numbers": {"backlash": ["110 mm", 0.13]}, "rate": "0.75 / min", "size": HIT["size"], "title": "Pump"}
    assert ReportJob(**written).digest == JOB.digest
    again = ReportJob.from_request(json.loads(json.dumps(JOB.request())))
    assert again.digest == JOB.digest and again.request() == JOB.request()
    assert JOB.request()["machine"] == PAIR.as_request
    assert ReportJob.trusted(JOB.request(), JOB.digest).oscillator == PAIR.oscillator


def test_a_normal_tolerance_stays_normal_in_the_request():
    written = ReportJob(**ASKED | {"numbers": {"backlash": "120 +- 10 mm, normal"}})
    assert written.request()["numbers"] == {"backlash": [0.12 - 0.01, 0.12 + 0.01, "normal"]}
    again = ReportJob.from_request(written.request())
    assert again.digest == written.digest != ReportJob(**ASKED).digest and again.production.ranges[0].normal


@pytest.mark.parametrize(
    ("change", "place", "said"),
    [
        ({"rate": 1.0}, ("size",), "give both, or neither"),
        ({"size": 1.0}, ("rate",), "give both, or neither"),
        ({"rate": 0.0, "size": 1.0}, ("rate",), "above 0"),
        ({"rate": 1.0, "size": "3 kg"}, ("size",), "cannot be in N m s"),
        ({"rate": 1.0, "size": "/etc/passwd.csv"}, ("size",), "is no number with a unit"),
        ({"rate": 1.0, "size": 1.0, "pressing": "held", "machine": {"mesh_stiffness": 1e7}}, ("pressing",), "impacts"),
        ({"distribution": "normal"}, ("distribution",), "give a size"),
        ({"speeds": 1}, ("speeds",), "a whole number from 2 on"),
        ({"departures": 3}, ("departures",), "a whole number from 4 on"),
        ({"seed": -1}, ("seed",), "a whole number from 0 on"),
        ({"numbers": {"backlash": "wide"}}, ("numbers", "backlash"), "is no tolerance"),
        ({"numbers": {"drag": [1, 2]}}, ("parameter",), "there is no number 'drag'"),
        ({"machines": 8}, ("machines",), "machines must be at least 32"),
        ({"machine": {"speed": 400.0}, "rate": 1.0, "size": 1.0}, ("rate",), "of a quiet machine: leave out rate and"),
        ({"machine": {"backlash": 0}}, ("machine",), "backlash"),
        ({"oscillator": {"damping": 0.5}}, ("machine",), "not both"),
        ({"certain": True, "numbers": {}}, ("certain",), "give numbers, which are its tolerances"),
    ],
)
def test_what_is_wrong_is_said_where_it_is_written(change, place, said):
    request = ASKED | change
    request["machine"] = ASKED["machine"] | change.get("machine", {})
    with pytest.raises(InvalidJob, match=said) as refused:
        ReportJob.from_request(request)
    assert refused.value.place == place


@pytest.mark.proof
@pytest.mark.timeout(600)  # the first proof compiles its kernels
def test_what_is_certain_of_the_production_is_on_the_page(client, tmp_path):
    job = ReportJob(**ASKED | {"certain": True, "numbers": {"backlash": [0.118, 0.122]}})
    location = str(tmp_path / "report.zarr")
    run_job(job, location, Driver(client), report=lambda _: None, cancel=threading.Event())
    study = rattle.tolerances(PAIR, {"backlash": (0.118, 0.122)}, machines=64, departures=32, prove=True)
    assert study.proven.speed > 0.0
    assert page_in(REPORT.read(location)[1]).decode().count(str(study.proven)) == 1


def test_nothing_is_certain_without_what_proves(monkeypatch):
    monkeypatch.setattr("rattle_machine.tolerances.can_prove", lambda: False)
    with pytest.raises(InvalidJob, match="prove needs the package rattle_proof, which is not installed"):
        ReportJob(**ASKED, certain=True)


@pytest.mark.parametrize("machine", ["machine.toml", 3, None])
def test_a_machine_is_never_a_file(machine):
    with pytest.raises(InvalidJob, match="a machine is an object"):
        ReportJob.from_request({"machine": machine})
