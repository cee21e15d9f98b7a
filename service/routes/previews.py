"""Small basins, computed while the client waits."""

from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Request, Response
from starlette.concurrency import run_in_threadpool

from service.answers.previews import MOST_APPLICATIONS, MOST_CELLS, Previews
from service.models.requests import described_as, parsed
from service.models.results import PreviewView
from service.routes.dependencies import ChecksHere, problems
from service.routes.plain_json import PlainJsonRoute
from worker.jobs.preview_request import PreviewRequest

router = APIRouter(prefix="/v1", tags=["previews"], route_class=PlainJsonRoute)
_BODY: Any = described_as(PreviewRequest, machine=True)


async def _previews(request: Request) -> Previews:
    previews: Previews = request.app.state.previews
    return previews


@router.post(
    "/previews",
    summary="Look at a basin at once",
    description=(
        "Compute a small basin of either model and return the motion that each cell ends in. Nothing is recorded. The "
        "request is that of a basin; by default it has 128 x 128 cells and k = 127, which shows the basin of k = 1499 "
        f"but for fine chaos. At most {MOST_CELLS} cells, and {MOST_APPLICATIONS} cells times iterations. The header "
        "Server-Timing has the milliseconds that it took, `wall`, and those that it had of a processor, `cpu`: the "
        "longer the first beside the second, the busier the machine."
    ),
    responses=problems(
        s400="malformed JSON",
        s413="body too large",
        s422="what is wrong with the request, field by field",
        s429="too many previews are waiting; the header Retry-After says when to try again",
    ),
)
async def preview(
    body: _BODY,
    request: Request,
    response: Response,
    previews: Annotated[Previews, Depends(_previews)],
    checks: ChecksHere,
) -> PreviewView:
    """Compute a small basin, unless its client goes away before."""

    async def gone() -> None:
        while (await request.receive())["type"] != "http.disconnect":
            pass

    asked = await checks.run(partial(parsed, PreviewRequest, body))
    basin, seconds, processor_seconds = await previews.compute(asked, gone)
    response.headers["Server-Timing"] = f"wall;dur={1000 * seconds:.1f}, cpu;dur={1000 * processor_seconds:.1f}"
    return await run_in_threadpool(lambda: PreviewView.from_preview(basin, asked.checked().iterations))
