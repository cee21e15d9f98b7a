"""Processors with fused multiply-add round alike, and it is known of the kernels whether they have it."""

import subprocess
import sys

import pytest

from tests.processors import NATIVE, ROOT, V2, V3, V4, environment_for, reason_against, run_on
from tests.rattle_kernels.numerics.small_maps import OF_DEPARTURES, OSCILLATORS

ASK = "from rattle_kernels.numerics.fused_multiply_add import fuses_multiply_add as fuses; print(fuses())"


@pytest.mark.parametrize(("target", "fused"), [(V2, False), (V3, True), (V4, True)])
def test_the_kernels_are_asked_whether_they_have_it(target, fused):
    command = [sys.executable, "-c", ASK]
    told = subprocess.run(command, cwd=ROOT, env=environment_for(target), capture_output=True, text=True, check=True)
    assert told.stdout.strip() == str(fused)


@pytest.fixture(scope="module")
def maps(tmp_path_factory):
    """Files of the maps by target: of those that this machine can run."""
    folder = tmp_path_factory.mktemp("maps")
    targets = [target for target in (NATIVE, V3, V4) if not reason_against(target)]
    run_on(targets, "tests.rattle_kernels.numerics.small_maps", folder)
    return {target: {file.name: file.read_bytes() for file in (folder / target).iterdir()} for target in targets}


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("target", [V3, V4])
def test_images_and_landing_points_of_both_models_are_the_same_bytes(maps, target):
    if reason := reason_against(target):
        pytest.skip(reason)
    assert len(maps[NATIVE]) == 3 * len(OSCILLATORS) + len(OF_DEPARTURES)
    assert maps[target] == maps[NATIVE]
