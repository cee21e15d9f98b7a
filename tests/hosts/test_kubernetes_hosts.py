"""The Kubernetes manifests' commands on hosts of a network: probes, keys, a worker's end, policies, the same bytes."""

import ipaddress
import os
import signal
import subprocess
import time

import psutil
import pytest

import rattle
from rattle_kernels import warm_up
from tests.hosts.cluster import BASIN, environment_of, hosts_of
from tests.hosts.manifests import parts_of_manifests
from tests.kubernetes.manifests import PASSWORDS, built, pods
from tests.kubernetes.policies import allowed

pytestmark = pytest.mark.hosts

COMPONENTS = {"service": "service", "gear-rattle-scheduler": "scheduler", "worker-1": "worker", "worker-2": "worker",
              "database": "database", "objects": "objects"}  # fmt: skip


@pytest.fixture(scope="module")
def objects(tmp_path_factory):
    return built(tmp_path_factory.mktemp("manifests"))


@pytest.fixture(scope="module")
def cluster(objects, tmp_path_factory):
    if os.geteuid() != 0:
        pytest.skip("network namespaces take root")
    warm_up()
    folder = tmp_path_factory.mktemp("pods")
    with hosts_of(parts_of_manifests(objects), folder, PASSWORDS["database"]["DATABASE_PASSWORD"]) as cluster:
        _wait_for_the_first_key(cluster, pods(objects)["service"][1]["initContainers"][0])
        with cluster.start():
            yield cluster


def _wait_for_the_first_key(cluster, container):
    """The first container of the service's pod ends when there is a key, and not before."""
    environment = environment_of(cluster.parts["service"])
    waiting = subprocess.Popen(cluster.network.on("service", container["command"]), env=environment)
    try:
        with pytest.raises(subprocess.TimeoutExpired):
            waiting.wait(10)
        cluster.add_key()
        assert waiting.wait(60) == 0
    finally:
        waiting.kill()


def test_a_worker_that_is_asked_to_end_leaves_in_time_and_the_result_is_that_of_one_machine(cluster, objects, tmp_path):
    job = cluster.submit()
    cluster.wait("tiles are done", lambda: (cluster.job(job)["progress"] or {}).get("tiles_done", 0) >= 2)
    grace = pods(objects)["gear-rattle-worker"][1]["terminationGracePeriodSeconds"]
    asked = worker_on(cluster, "worker-1")
    asked.send_signal(signal.SIGTERM)
    asked.wait(grace)
    cluster.wait("the basin is complete", lambda: cluster.succeeded(job))
    assert sample(cluster, "rattle_tiles_left") == 0
    rattle.basin(cells=(400, 400), iterations=BASIN["iterations"], store=tmp_path / "here.zarr", progress=False)
    files = [path for path in (tmp_path / "here.zarr").rglob("*") if path.is_file() and path.name != "zarr.json"]
    here = {str(path.relative_to(tmp_path / "here.zarr")): path.read_bytes() for path in files}
    there = {path: content for path, content in cluster.result(job).items() if not path.endswith("zarr.json")}
    assert there == here and len(here) > 50


def worker_on(cluster, host):
    """The first process of a worker's pod: Dask's command, below the commands that put it on its host."""
    log = cluster.folder / f"{host}.log"
    found = [process for process in psutil.process_iter(["cmdline"])
             if (process.info["cmdline"] or ["", ""])[1].endswith("/dask") and str(log) in opened(process)]  # fmt: skip
    assert len(found) == 1
    return found[0]


def opened(process):
    """Files that a process writes its output to."""
    return [os.readlink(f"/proc/{process.pid}/fd/{number}") for number in (1, 2)]


def sample(cluster, name):
    """Value of a metric."""
    lines = [line for line in cluster.request("GET", "/metrics").text.splitlines() if line.startswith(name + " ")]
    return float(lines[0].split()[-1])


def test_every_connection_between_pods_is_one_that_the_policies_allow(cluster, objects):
    """The hosts of these tests let everything through; a job runs meanwhile, so all parts speak with each other."""
    cluster.request("DELETE", f"/v1/jobs/{cluster.submit()}")  # an earlier test's, which would be there already
    job = cluster.submit()
    seen = set()
    patience = time.monotonic() + 240
    while not cluster.succeeded(job):
        assert time.monotonic() < patience
        seen |= connections(cluster)
    assert seen <= allowed(objects, "ingress")
    assert {("scheduler", "service", 8786), ("scheduler", "worker", 8786), ("database", "service", 5432),
            ("objects", "worker", 9000)} <= seen  # fmt: skip


def connections(cluster):
    """Component of the server, component of the client, and the server's port, of every connection between hosts."""
    hosts = {cluster.network.address(host): host for host in COMPONENTS}
    found = set()
    for host in COMPONENTS:
        listening = {port for _, port, _ in _sockets(cluster, host, "listening")}
        for _, port, peer in _sockets(cluster, host, "established"):
            client = hosts.get(peer)
            if port in listening and client not in (None, host):
                found.add((COMPONENTS[host], COMPONENTS[client], port))
    return found


def _sockets(cluster, host, state):
    """Local address, local port and peer of a host's sockets in a state."""
    command = cluster.network.on(host, ["ss", "--no-header", "--numeric", "--tcp", "state", state])
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    for line in lines:
        local, peer = line.split()[2:4]
        address, _, port = local.rpartition(":")
        yield address, int(port), _plain(peer.rpartition(":")[0])


def _plain(address):
    """An address as it is, or as IPv4 in IPv6."""
    bare = address.strip("[]")
    if bare == "*":
        return bare
    parsed = ipaddress.ip_address(bare)
    return str(getattr(parsed, "ipv4_mapped", None) or parsed)
