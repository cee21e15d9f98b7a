"""Answers that grow with a job are few at a time, come in pieces, and have bounds."""

import asyncio

import httpx2 as httpx
import numpy as np
import pytest
import xarray as xr
from fastapi import FastAPI
from fastapi.routing import iter_route_contexts

from rattle_kernels.numerics import jit
from service.answers import large_answers
from service.answers.large_answers import LargeAnswers
from service.errors import TooMuch
from service.middleware.pieces import Pieces
from service.models.jobs import JobPage
from service.routes.dependencies import LARGE
from tests.service.idle_service import idle_service
from worker.errors import InvalidJob
from worker.jobs.bifurcation_job import BifurcationJob
from worker.results.tables import demand_small_table


@pytest.fixture
def service(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path) as service:
        yield service


def test_a_few_are_made_at_a_time_and_a_bounded_number_waits(monkeypatch):
    monkeypatch.setattr(large_answers, "_MOST_WAITING", 3)

    async def visit():
        large, inside, most, release = LargeAnswers(), 0, 0, asyncio.Event()

        async def one():
            nonlocal inside, most
            async with large.place():
                inside += 1
                most = max(most, inside)
                await release.wait()
                inside -= 1

        waiting = [asyncio.create_task(one()) for _ in range(7)]
        await asyncio.sleep(0.01)
        with pytest.raises(TooMuch) as refused:
            await one()
        assert refused.value.seconds >= 1
        release.set()
        await asyncio.gather(*waiting)
        await one()  # all places are free again
        return most

    assert asyncio.run(visit()) == 4


def test_a_place_that_is_not_free_in_time_is_not_waited_for_longer(monkeypatch):
    monkeypatch.setattr(large_answers, "_WAITING_SECONDS", 0.01)

    async def visit():
        large = LargeAnswers()
        async with large.place(), large.place(), large.place(), large.place():
            with pytest.raises(TooMuch):
                async with large.place():
                    pass
        async with large.place():
            return True

    assert asyncio.run(visit())


def test_kernels_that_a_large_answer_needs_are_compiled_in_another_process():
    app = FastAPI()

    @app.get("/", dependencies=[LARGE])
    def compiles_apart() -> bool:
        return jit.before_compiling.get() is not None

    async def ask():
        app.state.large_answers = LargeAnswers()
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app=app), base_url="http://localhost") as client:
            answers = [(await client.get("/")).json() for _ in range(3)]
        return answers, jit.before_compiling.get()

    assert asyncio.run(ask()) == ([True, True, True], None)


def test_a_stopping_service_waits_for_no_kernel():
    async def leave():
        large = LargeAnswers()
        async with large.place():
            pause = jit.before_compiling.get().__self__._pause
            pause()
            large.close()
            pause()

    with pytest.raises(TooMuch, match="is stopping"):
        asyncio.run(leave())


def test_every_route_whose_answer_grows_with_a_job_has_a_place(service):
    of_a_job = {
        route.path.partition("{job_id}")[2]: LARGE in route.original_route.dependencies
        for route in iter_route_contexts(service.app.routes)
        if route.path and "{job_id}/" in route.path and "GET" in (route.methods or ())
    }
    # Events come one by one, and files of a store in chunks.
    small = {path for path, large in of_a_job.items() if not large}
    assert small == {"/events", "/result.zarr/{path:path}"}
    assert {"/result", "/result.json", "/result.csv", "/picture.png", "/shares.pdf", "/outline", "/tiles/{number}",
        "/overlays/{kind}", "/certificate.json"} <= of_a_job.keys()  # fmt: skip


def test_a_long_body_is_sent_in_pieces():
    body, sent = bytes(range(256)) * 4096, []

    async def app(scope, receive, send):
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": body})

    async def note(message):
        sent.append(message)

    asyncio.run(Pieces(app)({"type": "http"}, None, note))
    pieces = sent[1:]
    assert b"".join(piece["body"] for piece in pieces) == body
    assert max(len(piece["body"]) for piece in pieces) <= 65_536
    assert [piece["more_body"] for piece in pieces] == [True] * (len(pieces) - 1) + [False]


def test_a_table_of_too_many_rows_is_refused_with_the_address_of_the_store():
    cells = xr.Dataset({"group": (("velocity", "time"), np.zeros((400, 300), np.int8))})
    demand_small_table(cells, "group", 120_000, "/v1/jobs/0/result.zarr")
    with pytest.raises(InvalidJob, match="120000 rows.*119999.*/v1/jobs/0/result.zarr"):
        demand_small_table(cells, "group", 119_999, "/v1/jobs/0/result.zarr")


def test_a_page_of_long_requests_is_bounded_and_leads_to_the_others(service):
    seeds = [{"time": 0.5, "velocity": 4.0}]
    for number in range(40):
        values = (0.5 + np.arange(10_000) * 1e-6 + number * 1e-9).tolist()
        request = {"vary": {"parameter": "damping", "values": values}, "seeds": seeds, "kept": 1, "transient": 0}
        service.jobs.submit(BifurcationJob.from_request(request), "local")
    link, seen, longest = "/v1/jobs?size=200", [], 0
    while link:
        answer = service.request("GET", link)
        page = JobPage.model_validate_json(answer.content)
        seen, link, longest = seen + [job.id for job in page.jobs], page.next, max(longest, len(answer.content))
    assert len(seen) == len(set(seen)) == 40
    # A page ends after a MiB, and with the four jobs that were read together.
    assert longest < (1 << 20) + 4 * 250_000
