"""What the service stores of a request, and the digest by which it finds old results, stay the same."""

import json

import pytest

from tests.golden import adapter, door, files
from tests.golden.alike import differences

REQUESTS = files.read("requests.json")
REFUSALS = files.read("refusals.json")
TRAJECTORIES = files.read("trajectories.json")


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return tmp_path_factory.mktemp("golden")


@pytest.fixture(scope="module")
def idle(data):
    with adapter.idle(data) as service:
        yield service


@pytest.mark.parametrize("case", REQUESTS, ids=files.named(REQUESTS))
def test_a_request_is_stored_as_ever_under_the_same_digest(idle, data, case):
    assert door.stored_request(idle, data, case) == case


@pytest.mark.parametrize("case", REQUESTS, ids=files.named(REQUESTS))
def test_what_is_stored_asks_for_the_same(idle, data, case):
    again = door.stored_request(idle, data, case | {"body": json.loads(case["request"])})
    assert (again["request"], again["digest"]) == (case["request"], case["digest"])


@pytest.mark.parametrize("case", REFUSALS, ids=files.named(REFUSALS))
def test_a_wrong_request_is_refused_as_ever(idle, case):
    assert door.refusal(idle, case) == case


@pytest.mark.parametrize("case", TRAJECTORIES, ids=files.named(TRAJECTORIES))
def test_a_motion_is_followed_as_ever(idle, case):
    assert not differences(door.trajectory(idle, case), case)
