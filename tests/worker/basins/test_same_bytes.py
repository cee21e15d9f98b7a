"""Stores of basins are the same to the byte on processors with fused multiply-add, and others without."""

import pytest

from tests.processors import NATIVE, V2, V3, V4, reason_against, run_on
from tests.store_content import content
from tests.worker.basins.small_basins import JOBS

pytestmark = [pytest.mark.slow, pytest.mark.timeout(1800)]


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    """Files of the stores by target and basin: of those targets that this machine can run."""
    folder = tmp_path_factory.mktemp("stores")
    targets = [target for target in (NATIVE, V2, V3, V4) if not reason_against(target)]
    run_on(targets, "tests.worker.basins.small_basins", folder)
    return {target: {name: content(folder / target / name) for name in JOBS} for target in targets}


@pytest.mark.parametrize("name", JOBS)
@pytest.mark.parametrize("target", [V3, V4])
def test_every_array_of_a_basin_is_the_same_with_it(stores, target, name):
    if reason := reason_against(target):
        pytest.skip(reason)
    assert len(stores[NATIVE][name]) > 20
    assert stores[target][name] == stores[NATIVE][name]


@pytest.mark.parametrize("name", JOBS)
def test_a_basin_is_another_without_it(stores, name):
    """Shows that the other test would see it."""
    if reason := reason_against(V2):
        pytest.skip(reason)
    differing = {file for file in stores[V2][name] if stores[V2][name][file] != stores[NATIVE][name].get(file)}
    assert {file.split("/")[0] for file in differing} >= {"landing_time", "landing_velocity"}
