"""A kind that another package adds goes through every door: it takes files of its own and one entry."""

import json
import os
import shutil
import subprocess
import sys
from importlib.metadata import entry_points
from pathlib import Path

import pytest
from sqlalchemy import update
from typer.testing import CliRunner

from rattle import cli
from rattle.cli import app
from service.records.job_record import JobRecord
from service.routes.submit import submit_router
from tests.running_service import running_service
from tests.service.idle_service import idle_service
from worker.errors import UnknownKind
from worker.jobs.basin_job import basin_job
from worker.kinds import GROUP, KINDS, JobKind, Kinds, analysis_kind, kind_of
from worker.storage.location import result_location
from worker.stores.new_store import create_store

ROOT = Path(__file__).parents[2]
# Kinds that are not entered from outside, as those of packages beside are.
OWN = [kind for kind in KINDS.values() if kind.name not in {each.name for each in entry_points(group=GROUP)}]
REQUEST = {"phase": 0.25, "speed": 3.0, "periods": 12}


def install(folder, entry, package="impact-speeds"):
    """Make a folder as an installer does, with the entry points of a package."""
    described = folder / f"{package.replace('-', '_')}-1.0.dist-info"
    described.mkdir(parents=True)
    (described / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n")
    (described / "entry_points.txt").write_text(f"[rattle.kinds]\n{entry}\n")


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    """Folder of installed packages, with one that adds a kind."""
    folder = tmp_path_factory.mktemp("packages")
    shutil.copytree(Path(__file__).parent / "installed_kind" / "impact_speeds", folder / "impact_speeds")
    install(folder, "impact_speeds = impact_speeds.kind:KIND")
    return folder


@pytest.fixture
def service(tmp_path, monkeypatch):
    """A service that takes requests and runs none."""
    with idle_service(monkeypatch, tmp_path) as service:
        yield service


def python(packages, folder, code, *arguments):
    """What a program prints that finds the packages."""
    path = os.pathsep.join(map(str, (packages, ROOT)))
    command = [sys.executable, "-c", code, *map(str, arguments)]
    environment = os.environ | {"PYTHONPATH": path, "RATTLE_CACHE": str(folder / "cache")}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=100)
    assert done.returncode == 0, done.stderr
    return done.stdout


IN_PYTHON = """
import sys
import rattle
from impact_speeds.job import ImpactSpeedsJob

asked, url = ImpactSpeedsJob(phase=0.25, speed=3.0, periods=12), sys.argv[1]
here = rattle.compute(asked, store="here.zarr", progress=False)
there = rattle.connect(url).submit(asked).wait(progress=False).open()
assert here.rattle.kind == there.rattle.kind == "impact_speeds" and here.rattle.complete
assert here.impact_speed.values.tolist() == there.impact_speed.values.tolist()
assert here.rattle.job.digest == asked.digest and len(here.rattle.plot().axes[0].lines) == 1
print(here.sizes["impact"])
"""
SHELL = "from rattle.cli import app; app()"


@pytest.mark.slow
def test_an_installed_kind_is_served_drawn_listed_and_computed_by_python_here_and_there(packages, tmp_path):
    path = os.pathsep.join(map(str, (packages, ROOT)))
    with running_service(tmp_path, PYTHONPATH=path) as service:
        document = service.request("GET", "/openapi.json").json()
        body = document["paths"]["/v1/impact-speeds"]["post"]["requestBody"]["content"]["application/json"]["schema"]
        schemas = document["components"]["schemas"]
        assert "phase" in schemas[body["$ref"].rpartition("/")[2]]["properties"]
        assert "fastest" in schemas["ImpactSpeedsView"]["properties"]
        assert "impact_speeds" in schemas["JobView"]["properties"]["kind"]["enum"]
        assert json.dumps(document["paths"]["/v1/jobs/{job_id}/result"]).count("ImpactSpeedsView") >= 1

        told = service.request("GET", "/explorer/kinds.json").json()["impact_speeds"]
        assert told == {"path": "/v1/impact-speeds", "title": "Impact speeds"}

        refused = service.request("POST", "/v1/impact-speeds", json={"periods": 0})
        assert refused.status_code == 422 and refused.json()["errors"][0]["location"] == ["body", "periods"]
        assert service.request("POST", "/v1/checks", json={"kind": "impact_speeds"} | REQUEST).json()["accepted"]
        job = service.wait(service.submit(REQUEST, "impact-speeds")["id"])
        assert (job["kind"], job["state"]) == ("impact_speeds", "succeeded")
        result = service.request("GET", job["links"]["result"]).json()
        assert result["complete"] and result["impacts"] > 0 and result["fastest"] > 0.0
        assert service.request("GET", job["links"]["picture"]).content.startswith(b"\x89PNG")
        rows = service.request("GET", f"/v1/jobs/{job['id']}/result.json").json()
        assert len(rows) == result["impacts"] and max(row["impact_speed"] for row in rows) == pytest.approx(
            result["fastest"]
        )
        assert int(python(packages, tmp_path, IN_PYTHON, service.url)) == result["impacts"]


@pytest.mark.slow
def test_an_installed_kind_has_a_command_and_its_store_is_drawn_listed_exported_and_checked(packages, tmp_path):
    assert "List the impacts" in python(packages, tmp_path, SHELL, "--help")
    assert "--request" in python(packages, tmp_path, SHELL, "impact-speeds", "--help")
    (tmp_path / "request.json").write_text('{"phase": 0.25, "speed": 3, "periods": 12}')
    asked = "--request", "request.json", "--out", "shell.zarr", "--json"
    found = python(packages, tmp_path, SHELL, "impact-speeds", *asked)
    python(packages, tmp_path, SHELL, "plot", "shell.zarr", "--out", "picture.png")
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")
    table = python(packages, tmp_path, SHELL, "table", "shell.zarr")
    assert len(table.splitlines()) == json.loads(found)["impacts"] + 1
    python(packages, tmp_path, SHELL, "export", "shell.zarr", "--zip", "crate.zip")
    assert python(packages, tmp_path, SHELL, "check", "shell.zarr")


def test_the_entry_loads_neither_numba_nor_dask(packages, tmp_path):
    code = (
        "import sys; from worker.kinds import KINDS; KINDS['impact_speeds']; print({'numba', 'dask'} & {*sys.modules})"
    )
    assert python(packages, tmp_path, code).strip() == "set()"


@pytest.mark.parametrize(
    ("entry", "module", "told"),
    [
        ("no_kind = {0}:KIND", "KIND = 3", "no_kind = .*:KIND of the package one 1.0 is a int, no JobKind"),
        ("lost = {0}:KIND", "", "lost = .* cannot be loaded: .*KIND"),
        ("broken = {0}:KIND", "1 / 0", "broken = .* cannot be loaded: division by zero"),
        (
            "other = {0}:KIND",
            "from worker.kinds import KINDS; KIND = KINDS['orbits']",
            "other = .* names itself orbits",
        ),
        ("orbits = {0}:KIND", "from worker.kinds import KINDS; KIND = KINDS['orbits']", "orbits = .* clashes with orb"),
    ],
    ids=["no kind", "lost", "broken", "another name", "a known name"],
)
def test_an_entry_that_is_none_is_refused_with_its_package(tmp_path, monkeypatch, request, entry, module, told):
    name = "entry_" + request.node.callspec.id.replace(" ", "_")
    install(tmp_path, entry.format(name), "one")
    (tmp_path / f"{name}.py").write_text(module)
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(ImportError, match=f"the kind {told}"):
        dict(Kinds(OWN))


def test_a_route_that_is_taken_is_refused(tmp_path, monkeypatch):
    said = dict.fromkeys(("title", "summary", "description", "command", "job", "table"), "")
    install(tmp_path, "others = entry_of_a_taken_route:KIND", "one")
    (tmp_path / "entry_of_a_taken_route.py").write_text(
        f"from worker.kinds import analysis_kind\nKIND = analysis_kind('', name='others', path='orbits', **{said})"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(ImportError, match="others = .* clashes with orbits, whose route is orbits"):
        dict(Kinds(OWN))
    with pytest.raises(ValueError, match="the name 'Of Capitals' of a kind"):
        analysis_kind("", name="Of Capitals", path="others", **said)


def test_a_kind_that_is_not_there_is_named_with_those_that_are():
    with pytest.raises(UnknownKind, match="^there is no kind 'impact_speeds' here.*grazing_curve"):
        KINDS["impact_speeds"]
    assert KINDS.get("impact_speeds") is None and "impact_speeds" not in KINDS


@pytest.mark.slow
def test_a_store_whose_package_is_gone_is_named_by_every_command(packages, tmp_path):
    (tmp_path / "request.json").write_text(json.dumps(REQUEST))
    python(packages, tmp_path, SHELL, "impact-speeds", "--request", "request.json", "--out", "shell.zarr")
    for words in (["plot", "--out", "picture.png"], ["check"]):
        done = CliRunner().invoke(app, [words[0], str(tmp_path / "shell.zarr"), *words[1:]])
        assert done.exit_code == 1 and "install the package that adds it" in " ".join(done.output.split()), done.output


def test_a_job_whose_package_is_gone_is_listed_and_its_result_is_a_conflict(service):
    job = service.add_job()
    create_store(result_location(service.results, job.id), basin_job(job.request))
    with service.jobs._sessions() as session:
        session.execute(update(JobRecord).where(JobRecord.id == job.id).values(kind="impact_speeds"))
        session.commit()
    assert service.request("GET", "/v1/jobs").json()["jobs"][0]["kind"] == "impact_speeds"
    assert service.request("GET", f"/v1/jobs/{job.id}").status_code == 200
    for address in ("result", "picture.png", "result.csv", "outline"):
        answer = service.request("GET", f"/v1/jobs/{job.id}/{address}")
        assert answer.status_code == 409, answer.text


def test_a_command_or_a_route_of_another_door_is_refused(monkeypatch):
    monkeypatch.setitem(cli._BESIDE, "plot", ("a:b", "", ()))
    with pytest.raises(ImportError, match="asks for the command plot, which there is already"):
        cli.command_line()
    with pytest.raises(ImportError, match="the kind orbits asks for the route /v1/orbits"):
        submit_router({"/v1/orbits"})


@pytest.mark.parametrize(
    ("request_", "kind"), [({}, "basin"), ({"vary": []}, "sweep"), ({"kind": "orbits", "vary": {}}, "orbits")]
)
def test_a_request_without_a_kind_is_of_a_basin_or_a_sweep(request_, kind):
    assert kind_of(request_) == kind


@pytest.mark.parametrize("kind", KINDS.values(), ids=lambda kind: kind.name)
def test_the_class_of_a_kind_is_its_jobs(kind: JobKind):
    assert kind.job_class.model_fields["kind_"].default == kind.name
    assert "zarr" in kind.result_view.model_fields
