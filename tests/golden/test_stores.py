"""What is computed, how it lies in a store, and what is told of it stay the same, for a small job of every kind."""

import pytest

from tests.golden import files, jobs
from tests.golden.alike import differences

CASES = files.read("jobs.json")


@pytest.fixture(scope="module")
def done(service):
    """Finished jobs by their names."""
    return jobs.computed(service, CASES)


@pytest.fixture(scope="module", params=files.named(CASES))
def looks(request, service, done):
    """What is kept of one job: here and now, and in the golden file."""
    return jobs.looked_at(service, done[request.param]), files.read(f"stores/{request.param}.json")


@pytest.mark.parametrize("part", ["tree", "metadata", "tile", "pictures"])
def test_a_store_is_the_same_to_the_letter(looks, part):
    here, golden = looks
    assert here[part] == golden[part]


def test_arrays_hold_the_same_bytes(looks):
    here, golden = looks
    assert {name: held["sha256"] for name, held in here["arrays"].items()} == {
        name: held["sha256"] for name, held in golden["arrays"].items()
    }


@pytest.mark.parametrize("part", ["arrays", "job", "result", "outline"])
def test_a_result_is_told_in_the_same_fields_and_numbers(looks, part):
    here, golden = looks
    assert not differences(_without_hashes(here[part]), _without_hashes(golden[part]))


def _without_hashes(value):
    """Numbers of an array, by which one sees how far apart two are whose bytes differ."""
    if isinstance(value, dict):
        return {name: _without_hashes(each) for name, each in value.items() if name != "sha256"}
    return value
