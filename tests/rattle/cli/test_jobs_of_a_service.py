"""Jobs of a service are listed, shown and removed, whatever their kind."""

import pytest
from typer.testing import CliRunner

from rattle.cli import app
from tests.service.idle_service import idle_service


@pytest.fixture
def service(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path) as service:
        yield service


def asked(service, *arguments):
    return CliRunner().invoke(app, [*arguments, "--url", service.url], env={"COLUMNS": "80"})


BODIES = [
    ("basins", {"oscillator": {"model": "piecewise_linear", "stiffness": 1000}}, "stiffness 1000"),
    (
        "basins",
        {"oscillator": {"model": "piecewise_linear", "stiffness": 100, "eccentricity": 0.16,
                        "allow_no_quiet_solution": True}},
        "allow_no_quiet_solution True",
    ),
    (
        "sweeps",
        {"oscillator": {"model": "piecewise_linear"}, "vary": [{"parameter": "stiffness", "values": [1000, 2000]}]},
        "stiffness 1000 to 2000 (2)",
    ),
    ("orbits", {"longest": 1}, "damping 0.6"),
]  # fmt: skip


@pytest.mark.parametrize(("path", "body", "told"), BODIES)
def test_a_job_of_any_oscillator_is_listed_with_its_whole_id(service, path, body, told):
    job = service.request("POST", f"/v1/{path}", json=body).json()
    listed = asked(service, "jobs")
    assert listed.exit_code == 0, listed.output
    assert job["id"] in listed.output
    parameters = " ".join(line.split("│")[-2].strip() for line in listed.output.splitlines() if "│" in line)
    assert told in parameters


def test_the_first_digits_of_an_id_suffice(service):
    job = service.add_job()
    shown = asked(service, "status", job.id[:8])
    assert shown.exit_code == 0 and f"job {job.id}, basin: queued" in shown.output
    assert asked(service, "cancel", job.id[:8]).exit_code == 0
    assert asked(service, "delete", job.id).exit_code == 0
    gone = asked(service, "status", job.id[:8])
    assert gone.exit_code == 2 and "none of the 200 newest jobs" in " ".join(gone.output.split())


def test_digits_that_several_ids_share_are_refused(service):
    service.add_job(10), service.add_job(11)
    assert asked(service, "status", "").exit_code == 2
