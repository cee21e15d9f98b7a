"""Small jobs of every kind, computed by a service: what is kept of each."""

import hashlib

from tests.golden import shown, stores
from tests.golden.adapter import store_folder
from tests.golden.door import steady, submitted

LONGEST = 12
"""Lists of numbers that are longer are told by some of them."""


def computed(service, cases):
    """Finished jobs of the cases by their names."""
    begun = {case["name"]: submitted(service, case)["id"] for case in cases}
    done = {name: service.wait(job_id) for name, job_id in begun.items()}
    for job in done.values():
        assert job["state"] == "succeeded", job
    return done


def looked_at(service, job):
    """All that is kept of a finished job."""
    folder = store_folder(service, job)
    return {
        "job": steady(job, job["id"]),
        "result": _answer(service, job, "result"),
        "outline": _answer(service, job, "outline"),
        "tile": _tile(service, job),
        "pictures": _pictures(service, job),
        "chunks": stores.chunks(folder),
        "metadata": stores.metadata(folder),
        "arrays": stores.arrays(folder),
    } | shown.shown(folder)


def _get(service, job, path):
    return service.request("GET", f"/v1/jobs/{job['id']}/{path}")


def _answer(service, job, path):
    answer = _get(service, job, path)
    if answer.status_code != 200:
        return {"status": answer.status_code, "type": answer.json()["type"]}
    return _shortened(steady(answer.json(), job["id"]))


def _shortened(value):
    if isinstance(value, dict):
        return {name: _shortened(each) for name, each in value.items()}
    if not isinstance(value, list):
        return value
    if len(value) <= LONGEST or isinstance(value[0], dict):
        return [_shortened(each) for each in value]
    return {"length": len(value), "some": value[:: len(value) // 4]}


def _tile(service, job):
    answer = _get(service, job, "tiles/0")
    if answer.status_code != 200:
        return {"status": answer.status_code, "type": answer.json()["type"]}
    return {"shape": answer.headers["rattle-shape"], "sha256": hashlib.sha256(answer.content).hexdigest()}


def _pictures(service, job):
    return {path: _picture(_get(service, job, path)) for path in ("picture.png", "shares.png")}


def _picture(answer):
    if answer.status_code != 200:
        return {"status": answer.status_code, "type": answer.json()["type"]}
    return shown.picture(answer.content)
