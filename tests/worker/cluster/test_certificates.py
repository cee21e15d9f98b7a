"""Who has no certificate speaks to no part of a cluster, and nobody is told anything by its pages."""

import asyncio
import contextlib
import socket
import ssl
import stat
import subprocess
import sys
from urllib.request import urlopen

import pytest
from distributed import Client, LocalCluster, Security

from tests.running_service import free_port
from worker.cluster.certificates import make_certificates
from worker.cluster.connection import connect, count_workers, local_cluster
from worker.cluster.settings import Certificates
from worker.errors import ClusterFailed


@pytest.fixture(scope="module")
def certificates(tmp_path_factory):
    return make_certificates(tmp_path_factory.mktemp("certs"), days=2)


@pytest.fixture(scope="module")
def scheduler(certificates):
    """A scheduler that demands certificates, and a worker, as a shell starts them; its address."""
    flags = ["--tls-ca-file", certificates.authority, "--tls-cert", certificates.certificate]
    flags += ["--tls-key", certificates.key, "--no-dashboard"]
    address = f"tls://127.0.0.1:{free_port()}"
    dask = [sys.executable, "-m", "dask"]
    where = ["--protocol", "tls", "--host", "127.0.0.1", "--port", address.rpartition(":")[2]]
    commands = [
        [*dask, "scheduler", *where, *flags],
        [*dask, "worker", address, "--nthreads", "1", "--no-nanny", *flags],
    ]
    with contextlib.ExitStack() as stack:
        for command in commands:
            process = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            stack.callback(process.wait, 20)
            stack.callback(process.kill)
        yield address


def test_files_of_keys_are_their_owners_alone_and_are_not_overwritten(certificates):
    assert stat.S_IMODE(certificates.key.stat().st_mode) == 0o600
    before = certificates.key.read_bytes()
    with pytest.raises(FileExistsError):
        make_certificates(certificates.key.parent, days=2)
    assert certificates.key.read_bytes() == before


def test_a_client_with_the_certificate_computes(scheduler, certificates):
    with connect(scheduler, 1, certificates) as client:
        client.wait_for_workers(1, timeout=60)
        assert client.submit(abs, -7, pure=False).result(timeout=30) == 7
        assert count_workers(client, 5.0) == 1


def test_who_has_no_certificate_of_this_authority_cannot_connect(scheduler, certificates, tmp_path):
    others = make_certificates(tmp_path, days=2)
    mixed = Certificates(certificates.authority, others.certificate, others.key)
    for address, given in ((scheduler.replace("tls://", "tcp://"), None), (scheduler, others), (scheduler, mixed)):
        security = given and Security(
            tls_ca_file=str(given.authority), tls_client_cert=str(given.certificate), tls_client_key=str(given.key),
            require_encryption=True,
        )  # fmt: skip
        with pytest.raises((OSError, RuntimeError)):
            Client(address, security=security, timeout=2, set_as_default=False).close()


def test_a_connection_without_any_certificate_is_told_nothing(scheduler, certificates):
    context = ssl.create_default_context(cafile=certificates.authority)
    context.check_hostname = False
    host, port = scheduler.removeprefix("tls://").split(":")
    with socket.create_connection((host, int(port)), timeout=10) as line:
        with pytest.raises(ssl.SSLError, match="certificate required|alert"), context.wrap_socket(line) as encrypted:
            assert encrypted.recv(1) == b"", "something was said"


def test_certificates_that_are_not_there_are_named(scheduler, certificates, tmp_path):
    gone = Certificates(certificates.authority, certificates.certificate, tmp_path / "gone.pem")
    with pytest.raises(ClusterFailed, match="gone.pem.*rattle certs"), connect(scheduler, 1, gone):
        pass


def test_the_embedded_cluster_is_encrypted_and_its_pages_are_empty():
    with local_cluster(1) as client:
        assert client.scheduler.address.startswith("tls://127.0.0.1:")
        info = client.scheduler_info()
        ports = [info["services"]["dashboard"]]
        ports += [each["services"]["dashboard"] for each in info["workers"].values() if "dashboard" in each["services"]]
        for port in ports:
            for page in ("", "status", "info/main/workers.html", "metrics", "health", "json/identity.json"):
                with pytest.raises(OSError, match="404"):
                    urlopen(f"http://127.0.0.1:{port}/{page}", timeout=5)
        plain = client.scheduler.address.replace("tls://", "tcp://")
        with pytest.raises(OSError):
            Client(plain, timeout=1, set_as_default=False).close()


def test_a_scheduler_that_hangs_has_no_workers_within_the_time():
    with LocalCluster(n_workers=1, processes=False, dashboard_address="127.0.0.1:0") as cluster:
        with Client(cluster, set_as_default=False) as client:
            assert count_workers(client, 5.0) == 1
            answered = []

            async def late(**_):
                await asyncio.sleep(30)
                answered.append(True)

            cluster.scheduler.handlers["ncores"] = late
            assert count_workers(client, 0.5) == 0
            assert not answered
