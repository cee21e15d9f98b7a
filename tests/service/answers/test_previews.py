"""Previews end with their service."""

import asyncio

import pytest

from service.answers.previews import Previews
from worker.basins.preview_request import PreviewRequest
from worker.errors import JobCancelled

# So stiff that each motion takes long to find.
SLOW = PreviewRequest(oscillator={"model": "piecewise_linear", "stiffness": 1_000_000}, iterations=1499)


async def _closed_in_the_middle():
    previews, stays = Previews(), asyncio.Event().wait
    asked = [asyncio.create_task(previews.compute(SLOW, stays)) for _ in range(5)]
    await asyncio.sleep(0.5)
    previews.close()
    return await asyncio.wait_for(asyncio.gather(*asked, return_exceptions=True), 10)


def test_a_stopping_service_waits_for_no_preview():
    # Two ran, and three waited.
    ends = {type(end) for end in asyncio.run(_closed_in_the_middle())}
    assert ends <= {JobCancelled, asyncio.CancelledError}, ends


def test_a_previews_client_may_stay_or_go():
    async def asked_by_one_who_leaves():
        with pytest.raises(JobCancelled, match="is gone"):
            await Previews().compute(SLOW, lambda: asyncio.sleep(0.2))

    asyncio.run(asyncio.wait_for(asked_by_one_who_leaves(), 10))
