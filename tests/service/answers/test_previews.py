"""Previews end with their service."""

import asyncio

import pytest

from rattle_kernels.numerics import jit
from service.answers import previews
from service.answers.previews import Previews
from worker.errors import JobCancelled
from worker.jobs.preview_request import PreviewRequest

# So stiff that each motion takes long to find.
SLOW = PreviewRequest(oscillator={"model": "piecewise_linear", "stiffness": 1_000_000}, iterations=1499)


async def _closed_in_the_middle():
    computes, stays = Previews(), asyncio.Event().wait
    asked = [asyncio.create_task(computes.compute(SLOW, stays)) for _ in range(5)]
    await asyncio.sleep(0.5)
    computes.close()
    return await asyncio.wait_for(asyncio.gather(*asked, return_exceptions=True), 10)


def test_a_stopping_service_waits_for_no_preview():
    # Two ran, and three waited.
    ends = {type(end) for end in asyncio.run(_closed_in_the_middle())}
    assert ends <= {JobCancelled, asyncio.CancelledError}, ends


def test_a_preview_compiles_in_another_process_however_long_that_takes(monkeypatch):
    compiles_apart, small = [], PreviewRequest(iterations=1)

    def leave():
        compiler = jit.before_compiling.get().__self__
        compiler._pause()  # as while it waits for that process
        compiles_apart.append(compiler)

    monkeypatch.setattr(previews, "_MOST_SECONDS", -1.0)
    monkeypatch.setattr(previews, "preview_basin", lambda request, pause: leave())
    asyncio.run(Previews().compute(small, asyncio.Event().wait))
    assert compiles_apart


def test_a_previews_client_may_stay_or_go():
    async def asked_by_one_who_leaves():
        with pytest.raises(JobCancelled, match="is gone"):
            await Previews().compute(SLOW, lambda: asyncio.sleep(0.2))

    asyncio.run(asyncio.wait_for(asked_by_one_who_leaves(), 10))
