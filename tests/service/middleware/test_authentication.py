"""Which requests are let through, and for what."""

import re
import time

import pytest
import xarray as xr
from typer.testing import CliRunner

from rattle.cli import app as rattle
from service.records import keys as keys_module
from service.records.engine import open_database
from service.records.keys import Keys, KeyScope
from service.settings import Settings
from tests.service.idle_service import idle_service
from worker.errors import InvalidSettings
from worker.jobs.basin_job import basin_job
from worker.stores.new_store import create_store


@pytest.fixture(autouse=True)
def refreshes_at_once(monkeypatch):
    monkeypatch.setattr(keys_module, "_REFRESH_SECONDS", 0.05)
    monkeypatch.setattr(keys_module, "_NOTE_USE_SECONDS", 0.0)


@pytest.fixture
def open_service(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path) as service:
        yield service


@pytest.fixture
def service(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path, require_keys=True) as service:
        yield service


def keys_of(service):
    return Keys(service.jobs._sessions)


def bearer(key):
    return {"authorization": f"Bearer {key}"}


def command(*arguments):
    return CliRunner().invoke(rattle, arguments)


def test_on_loopback_no_key_is_needed(open_service):
    assert open_service.request("GET", "/v1/jobs").status_code == 200
    assert open_service.request("GET", "/metrics").status_code == 200
    # A key that a client happens to send anyway does no harm.
    assert open_service.request("GET", "/v1/jobs", headers=bearer("rattle_any")).status_code == 200


def test_without_keys_a_web_page_that_has_its_name_point_here_reads_nothing(open_service):
    answer = open_service.request("GET", "/v1/jobs", headers={"host": "evil.example:8000"})
    assert answer.status_code == 421 and answer.json()["type"] == "/problems/misdirected-request"
    for name in ("localhost", "127.0.0.1:1", "[::1]:8000"):
        assert open_service.request("GET", "/v1/jobs", headers={"host": name}).status_code == 200


def test_the_first_key_closes_the_service_and_revoking_it_does_not_open_it(open_service):
    key = keys_of(open_service).add("ann", [KeyScope.READ])
    time.sleep(0.1)
    assert open_service.request("GET", "/v1/jobs").status_code == 401
    assert open_service.request("GET", "/v1/jobs", headers=bearer(key)).status_code == 200
    assert [record.name for record in keys_of(open_service).revoke("ann")] == ["ann"]
    time.sleep(0.1)
    assert open_service.request("GET", "/v1/jobs", headers=bearer(key)).status_code == 401
    assert open_service.request("GET", "/v1/jobs").status_code == 401


@pytest.mark.parametrize("path", ["/v1/jobs", "/v1/nothing", "/metrics", "/explorer", "/v1/../metrics", "//v1/jobs"])
def test_everything_is_closed_that_is_not_named_as_open(service, path):
    answer = service.request("GET", path)
    assert answer.status_code == 401
    assert answer.headers["www-authenticate"].startswith("Bearer")
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["type"] == "/problems/key-required" and "authorization: Bearer" in answer.json()["detail"]


@pytest.mark.parametrize(
    "path", ["/healthz", "/readyz", "/docs", "/docs/show.js", "/openapi.json", "/", "/explorer/index.html"]
)
def test_health_the_description_of_the_api_and_the_page_are_open(service, path):
    assert service.request("GET", path).status_code == 200


def test_a_body_is_not_looked_at_before_the_key(service):
    for body in ("{", '{"iterations": 1, "iterations": 2}', " " * 2_000_000):
        assert service.request("POST", "/v1/basins", content=body).status_code == 401


def test_a_wrong_key_is_refused_whatever_of_it_is_right(service):
    key = keys_of(service).add("ann", [KeyScope.ADMIN])
    time.sleep(0.1)
    assert service.request("GET", "/v1/jobs", headers=bearer(key)).status_code == 200
    wrong = [key[:-1], key + "x", key.upper(), key[:15], "rattle_", "ä".encode().decode("latin-1")]
    for given in [f"Bearer {each}" for each in wrong] + [f"Basic {key}", key, f"Bearer {key},{key}"]:
        answer = service.request("GET", "/v1/jobs", headers={"authorization": given.encode("latin-1")})
        assert answer.status_code == 401, given
        assert answer.json()["type"] == "/problems/key-unknown"
        assert 'error="invalid_token"' in answer.headers["www-authenticate"]


def test_a_scope_that_is_missing_is_named(service):
    reader, submitter = keys_of(service).add("ann", [KeyScope.READ]), keys_of(service).add("bob", [KeyScope.SUBMIT])
    time.sleep(0.1)
    body = {"grid": {"time": {"cells": 4}, "velocity": {"cells": 4}}, "iterations": 1}
    refused = service.request("POST", "/v1/basins", json=body, headers=bearer(reader))
    assert refused.status_code == 403 and refused.json()["type"] == "/problems/scope-missing"
    assert refused.json()["detail"] == "this needs the scope submit; the key of ann has read"
    assert 'scope="submit"' in refused.headers["www-authenticate"]
    accepted = service.request("POST", "/v1/basins", json=body, headers=bearer(submitter))
    assert accepted.status_code == 202
    assert service.request("GET", "/v1/jobs", headers=bearer(submitter)).status_code == 403
    assert service.jobs.get(accepted.json()["id"]).submitter == "bob"


def test_a_job_is_stopped_by_who_submitted_it_or_by_an_administrator(service):
    keys = keys_of(service)
    ann, bob, eve = (keys.add(name, [KeyScope.SUBMIT]) for name in ("ann", "bob", "eve"))
    boss = keys.add("boss", [KeyScope.ADMIN])
    time.sleep(0.1)
    first, second = service.add_job(10, "ann"), service.add_job(11, "ann")
    for method, path in (("POST", f"/v1/jobs/{first.id}/cancel"), ("DELETE", f"/v1/jobs/{first.id}")):
        for key in (bob, eve):
            answer = service.request(method, path, headers=bearer(key))
            assert answer.status_code == 403 and "was submitted by ann" in answer.json()["detail"]
    assert service.request("POST", f"/v1/jobs/{first.id}/cancel", headers=bearer(ann)).status_code == 202
    assert service.request("DELETE", f"/v1/jobs/{second.id}", headers=bearer(boss)).status_code == 204


def test_the_database_holds_no_key_and_knows_when_one_was_used(service, tmp_path):
    key = keys_of(service).add("ann", [KeyScope.READ])
    time.sleep(0.1)
    for _ in range(2):
        assert service.request("GET", "/v1/jobs", headers=bearer(key)).status_code == 200
        time.sleep(0.1)
    record = keys_of(service).all()[0]
    assert record.last_used is not None and record.prefix == key[:15] and len(key) == 50
    raw = b"".join(path.read_bytes() for path in tmp_path.glob("jobs.sqlite*"))
    assert record.prefix.encode() in raw and key.encode() not in raw and key[15:].encode() not in raw


def test_keys_are_made_listed_and_revoked_from_a_shell(tmp_path):
    data = ("--data", str(tmp_path))
    made = command("keys", "add", "ann", "--scope", "read", *data)
    key = made.stdout.strip()
    assert made.exit_code == 0 and re.fullmatch(r"rattle_[\w-]{43}", key)
    listed = command("keys", "list", *data).stdout
    assert "ann" in listed and key not in listed
    second = command("keys", "add", "ann", *data).stdout.strip()
    assert command("keys", "revoke", key[:15], *data).exit_code == 0
    engine, sessions = open_database(f"sqlite:///{tmp_path / 'jobs.sqlite'}")
    live, _ = Keys(sessions).live()
    engine.dispose()
    assert [(record.prefix, record.scopes) for record in live] == [(second[:15], "read submit")]
    assert command("keys", "revoke", key[:15], *data).exit_code == 2
    for name in ("local", "", "a b", "x" * 65, "../up"):
        assert command("keys", "add", name, *data).exit_code == 2


@pytest.mark.parametrize("name", ["0.0.0.0", "::", "192.0.2.1", "example.org", ""])
def test_beyond_loopback_a_service_without_keys_does_not_start_and_says_what_to_do(tmp_path, name):
    refused = command("serve", "--host", name, "--data", str(tmp_path))
    assert refused.exit_code == 2 and "rattle keys add" in refused.stderr


def test_a_revoked_key_does_not_start_it_either(tmp_path):
    data = ("--data", str(tmp_path))
    command("keys", "add", "ann", *data)
    command("keys", "revoke", "ann", *data)
    refused = command("serve", "--host", "0.0.0.0", *data)
    assert refused.exit_code == 2
    assert "0.0.0.0 is no loopback address" in refused.stderr and "rattle keys add" in refused.stderr


def test_answers_carry_headers_that_keep_browsers_from_misusing_them(open_service):
    job = open_service.add_job()
    for path, policy, cache in (
        ("/v1/jobs", "default-src 'none'", "no-store"),
        ("/docs", "default-src 'self'", "no-cache"),
        ("/nothing", "default-src 'none'", "no-store"),
    ):
        headers = open_service.request("GET", path).headers
        assert headers["x-content-type-options"] == "nosniff" and headers["referrer-policy"] == "no-referrer"
        assert policy in headers["content-security-policy"]
        assert "frame-ancestors 'none'" in headers["content-security-policy"]
        assert headers["cache-control"] == cache and "server" not in headers
    assert open_service.request("GET", f"/v1/jobs/{job.id}").headers["cache-control"] == "private, no-cache"


def test_the_explorer_is_framed_by_those_alone_who_may(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path, framed_by="https://wiki.example.org http://localhost:*") as here:
        policies = [here.request("GET", path).headers["content-security-policy"] for path in ("/", "/docs", "/v1/jobs")]
    assert "frame-ancestors https://wiki.example.org http://localhost:*" in policies[0]
    assert all("frame-ancestors 'none'" in policy for policy in policies[1:])


@pytest.mark.parametrize("wrong", ["", "wiki.example.org", "https://a.org; script-src *", "https://a.org 'self'"])
def test_what_may_frame_it_is_an_origin(wrong):
    with pytest.raises(InvalidSettings, match="^framed_by: give origins with spaces between them"):
        Settings(framed_by=wrong)


def test_a_store_opens_with_a_key(service, tmp_path):
    key = keys_of(service).add("ann", [KeyScope.READ])
    time.sleep(0.1)
    job = service.add_job()
    store = tmp_path / "results" / f"{job.id}.zarr"
    create_store(str(store), basin_job(job.request))
    address = f"{service.url}/v1/jobs/{job.id}/result.zarr"
    with xr.open_zarr(address, storage_options={"headers": bearer(key)}) as basin:
        assert basin.attrs["complete"] is False
    with pytest.raises(Exception, match="401|Unauthorized|No such|not found"):
        xr.open_zarr(address)
