"""A store that loses its root while its job runs does not keep the request from being computed again."""

from pathlib import Path

from tests.faults.conftest import BASIN


def test_the_same_request_is_computed_after_its_store_lost_its_root(a_service):
    with a_service() as service:
        job = service.submit(BASIN)
        service.wait(job["id"], lambda job: job["progress"] and job["progress"]["tiles_done"] >= 1)
        (Path(service.store_of(job)) / "zarr.json").unlink()
        ended = service.wait(job["id"])
        again = service.wait(service.submit(BASIN)["id"])
        print(ended["state"], ended["error"], again["id"] == job["id"])
        assert again["state"] == "succeeded", again
        assert service.request("GET", again["links"]["result"]).json()["complete"] is True
