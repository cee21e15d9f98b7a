"""The compose file's commands on hosts of a network: a basin, a host that is cut off and comes back, the same bytes."""

import os
import time

import httpx2 as httpx
import pytest

from rattle_kernels import warm_up
from tests.hosts.cluster import hosts_of
from tests.hosts.compose import parts_of_compose_file

pytestmark = pytest.mark.hosts

SECRETS = {"DATABASE_PASSWORD": "secret-1", "OBJECTS_ACCESS_KEY": "tests", "OBJECTS_SECRET_KEY": "no secret"}


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    if os.geteuid() != 0:
        pytest.skip("network namespaces take root")
    warm_up()  # as in the image, no worker has to compile
    parts = parts_of_compose_file(SECRETS)
    with hosts_of(parts, tmp_path_factory.mktemp("hosts"), SECRETS["DATABASE_PASSWORD"]) as cluster:
        cluster.add_key()
        with cluster.start():
            yield cluster


@pytest.fixture(scope="module")
def undisturbed(cluster):
    job = cluster.submit()
    cluster.wait("the basin is complete", lambda: cluster.succeeded(job))
    objects = cluster.result(job)
    # The same request is the same job as long as that is there.
    assert cluster.request("DELETE", f"/v1/jobs/{job}").status_code == 204
    assert cluster.objects.objects("gear-rattle") == {}
    return objects


def test_a_worker_that_is_cut_off_is_given_up_and_comes_back_and_the_result_is_the_same(cluster, undisturbed):
    job = cluster.submit()
    cluster.wait("tiles are done", lambda: (cluster.job(job)["progress"] or {}).get("tiles_done", 0) >= 2)
    cluster.network.cut("worker-1")
    cluster.wait("the scheduler gives it up", lambda: cluster.workers() == 1)
    cluster.network.mend("worker-1")
    cluster.wait("it is back", lambda: cluster.workers() == 2)
    cluster.wait("the basin is complete", lambda: cluster.succeeded(job))
    assert cluster.result(job) == undisturbed
    assert cluster.request("DELETE", f"/v1/jobs/{job}").status_code == 204


def test_a_scheduler_that_is_cut_off_is_found_again(cluster, undisturbed):
    job = cluster.submit()
    cluster.wait("tiles are done", lambda: (cluster.job(job)["progress"] or {}).get("tiles_done", 0) >= 2)
    cluster.network.cut("scheduler")
    time.sleep(5.0)
    cluster.network.mend("scheduler")
    cluster.wait("the basin is complete", lambda: cluster.succeeded(job))
    assert cluster.result(job) == undisturbed
    assert cluster.workers() == 2


def test_strangers_are_let_in_nowhere(cluster):
    url = f"http://{cluster.network.address('service')}:8000/v1/jobs"
    assert httpx.get(url, timeout=10).status_code == 401
    code = (
        "from distributed import Client\n"
        "try: Client('tcp://scheduler:8786', timeout=3)\n"
        "except Exception as error: print('refused')\n"
    )
    assert "refused" in cluster.once("worker-1", ["python", "-W", "ignore", "-c", code])
