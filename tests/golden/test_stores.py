"""What is computed, how it lies in a store, and what is told of it stay the same, for a small job of every kind."""

import pytest

from tests.golden import files, jobs
from tests.golden.alike import differences

CASES = {case["name"]: case for case in files.read("jobs.json")}
FOLLOWED = ("branch_", "curve_", "special_", "point_")
"""Arrays of what is followed in a parameter: linear algebra makes their last digits, and each processor its own."""

# The first test of all waits for the jobs of all.
pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]


@pytest.fixture(scope="module")
def done(request, service):
    """Finished jobs by their names: of those that are asked for, all at once."""
    asked = {item.callspec.params.get("looks") for item in request.session.items if hasattr(item, "callspec")}
    return jobs.computed(service, [case for name, case in CASES.items() if name in asked])


@pytest.fixture(scope="module", params=CASES)
def looks(request, service, done):
    """What is kept of one job: here and now, and in the golden file."""
    return jobs.looked_at(service, done[request.param]), files.read(f"stores/{request.param}.json")


@pytest.mark.parametrize("part", ["chunks", "metadata", "tile"])
def test_a_store_is_the_same_to_the_letter(looks, part):
    here, golden = looks
    assert here[part] == golden[part]


def test_arrays_hold_the_same_bytes(looks):
    here, golden = looks
    assert _hashes(here) == _hashes(golden)


@pytest.mark.parametrize("part", ["arrays", "job", "result", "outline", "tables", "measured"])
def test_a_result_is_told_in_the_same_fields_and_numbers(looks, part):
    here, golden = looks
    assert not differences(_without_hashes(here[part]), _without_hashes(golden[part]))


@pytest.mark.parametrize("part", ["pictures", "drawn"])
def test_pictures_have_the_same_pixels(looks, part):
    """Of what is followed, whose last digits are each processor's own, a line may lie in the next pixel."""
    here, golden = looks
    if here["job"]["request"].get("continuation") or here["job"]["kind"] == "chart":
        here, golden = _sizes(here[part]), _sizes(golden[part])
        assert here == golden
    else:
        assert here[part] == golden[part]


def _sizes(drawn):
    if isinstance(drawn, dict) and "size" not in drawn:
        return {name: _sizes(each) for name, each in drawn.items()}
    return drawn["size"] if isinstance(drawn, dict) else drawn


def _hashes(look):
    """Hash of what each array holds, but for those that linear algebra has had a part in."""
    parameter = look["job"]["request"].get("continuation", {}).get("parameter")
    exact = {name: held for name, held in look["arrays"].items() if name != parameter}
    return {name: held["sha256"] for name, held in exact.items() if not name.startswith(FOLLOWED)}


def _without_hashes(value):
    """Numbers of arrays, by which one sees how far apart two are whose bytes differ."""
    if isinstance(value, dict):
        return {name: _without_hashes(each) for name, each in value.items() if name != "sha256"}
    return value
