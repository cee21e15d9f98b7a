"""What is proven of a basin over HTTP, as explorer and pictures have it; and basins without a proof as they were."""

import numpy as np
import pytest

from tests.rattle_proof.proven_store import lay_proof
from tests.service.routes.problems import assert_problem

CELLS = 130
SMALL = {"grid": {"time": {"cells": CELLS}, "velocity": {"cells": CELLS}}, "iterations": 181}
ENDINGS = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}


def made_up():
    """A proof with another number in each row, and every reason."""
    proven = np.broadcast_to(np.arange(CELLS)[:, None] % 65, (CELLS, CELLS)).astype(np.uint8)
    return proven, np.where(proven == 64, 0, 1 + proven % 4).astype(np.uint8)


@pytest.fixture(scope="module")
def unproven(service):
    return service.wait(service.submit(SMALL)["id"])


@pytest.fixture(scope="module")
def proven(service):
    job = service.wait(service.submit(SMALL | {"iterations": 191})["id"])
    lay_proof(service.store_of(job), *made_up())
    return job


def get(service, job, path, **options):
    return service.request("GET", f"/v1/jobs/{job['id']}/{path}", **options)


@pytest.mark.parametrize("every", [1, 3])
def test_tiles_say_what_is_proven_after_their_labels(service, proven, every):
    told = get(service, proven, "outline").json()["tiles"]
    found = [[], []]
    for number in range(told["down"] * told["across"]):
        answer = get(service, proven, f"tiles/{number}?every={every}")
        rows, columns = map(int, answer.headers["rattle-shape"].split())
        assert len(answer.content) == 16 * rows * columns
        parts = np.frombuffer(answer.content, np.uint8, offset=14 * rows * columns).reshape(2, rows, columns)
        for whole, part in zip(found, parts, strict=True):
            whole.append(part)
    for whole, made in zip(found, made_up(), strict=True):
        rows = [whole[row : row + told["across"]] for row in range(0, len(whole), told["across"])]
        np.testing.assert_array_equal(np.block(rows), made[::every, ::every])


def test_without_a_proof_all_is_as_it_was(service, unproven):
    assert "proof" not in get(service, unproven, "outline").json()
    answer = get(service, unproven, "tiles/0")
    rows, columns = map(int, answer.headers["rattle-shape"].split())
    assert len(answer.content) == 14 * rows * columns


def test_a_proof_that_was_asked_for_is_told_before_it_is_there(service):
    job = service.wait(service.submit(SMALL | {"iterations": 193})["id"])
    proof, reason = made_up()
    proof[-1], reason[-1] = 255, 255
    lay_proof(service.store_of(job), proof, reason)
    outline = get(service, job, "outline").json()
    assert outline["proof"] is True
    sizes = {}
    for number in range(outline["tiles"]["down"] * outline["tiles"]["across"]):
        answer = get(service, job, f"tiles/{number}")
        rows, columns = map(int, answer.headers["rattle-shape"].split())
        sizes[number // outline["tiles"]["across"]] = len(answer.content) // (rows * columns)
    assert set(sizes.values()) == {14, 16} and sizes[max(sizes)] == 14


@pytest.mark.parametrize("ending", ENDINGS)
def test_pictures_of_every_format_have_the_overlay(service, proven, ending):
    plain, hatched, again = (
        get(service, proven, f"picture.{ending}?overlays={overlays}") for overlays in ("", "proven", "proven")
    )
    assert hatched.status_code == 200 and hatched.content.startswith(ENDINGS[ending])
    assert hatched.content == again.content != plain.content
    assert hatched.headers["etag"] != plain.headers["etag"]


def test_what_is_not_there_is_told_so(service, unproven, proven):
    answer = get(service, unproven, "picture.png?overlays=proven")
    assert_problem(answer, 422, "nothing is proven of this basin")
    assert_problem(get(service, proven, "overlays/proven"), 422, "what is proven comes with the cells")
