"""A tile that kills whoever computes it fails its own job, and no other."""

from tests.faults.conftest import BASIN
from tests.faults.farm import starts
from tests.faults.preload import POISON

POISONED = {
    "grid": {"time": {"cells": 64}, "velocity": {"cells": 64}}, "iterations": 101,
    "oscillator": {"damping": POISON, "eccentricity": 0.1, "half_backlash": 0.6},
}  # fmt: skip


def test_a_poison_tile_fails_its_own_job_only(a_service, right, undisturbed, starts_file):
    with a_service() as service:
        innocent = service.submit(BASIN)
        poisoned = service.wait(service.submit(POISONED)["id"])
        assert poisoned["state"] == "failed" and poisoned["error"]["kind"] == "tile-failed"
        assert "KilledWorker" in poisoned["error"]["detail"] and "map_tile 0" in poisoned["error"]["detail"]
        assert service.wait(innocent["id"])["state"] == "succeeded"
        deaths = starts(starts_file).total() - undisturbed["basin"].tiles
        assert 2 <= deaths <= 20
        service.wait_until_ready()  # the workers that it has killed come back
