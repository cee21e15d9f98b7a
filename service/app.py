"""The FastAPI application: its state while it runs, its middleware and its routes."""

import contextlib
import gc
import threading
from collections.abc import AsyncIterator
from importlib.metadata import version

from anyio import to_thread
from fastapi import Depends, FastAPI
from fastapi.routing import APIRoute
from starlette.middleware.gzip import DEFAULT_EXCLUDED_CONTENT_TYPES, GZipMiddleware

from rattle_kernels import warm_up_curves
from rattle_kernels.numerics.compiled_apart import compiled_apart
from service.answers.event_feed import EventFeed
from service.answers.large_answers import LargeAnswers
from service.answers.previews import Previews
from service.answers.readiness import Probe, Probes
from service.answers.request_checks import RequestChecks
from service.api_document import describe
from service.middleware.access import Access
from service.middleware.authentication import Authentication
from service.middleware.pieces import Pieces
from service.middleware.plain_requests import PlainRequests
from service.middleware.security_headers import SecurityHeaders
from service.problems import install_error_handlers
from service.records.engine import open_database
from service.records.events import Events
from service.records.jobs import Jobs
from service.records.keys import KeyRing, Keys
from service.routes import (
    checks,
    events,
    health,
    jobs,
    machines,
    pages,
    previews,
    results,
    trajectories,
    viewer,
)
from service.routes.dependencies import refuse_unknown_parameters
from service.routes.plain_json import HeldBodies
from service.routes.submit import submit_router
from service.runner.process import RunnerProcess
from service.settings import Settings
from worker.additions import additions
from worker.estimate import measured_speed
from worker.kinds import KINDS

# Compiled kernels load in a second. Compiling them takes a minute, and a stopping service does not wait for that.
_LOADED_SECONDS = 2.0
# The state of a job is smaller, and is read a hundred times as often as anything else.
_LEAST_COMPRESSED = 4096
# Chunks of stores are compressed already, and tiles by their route.
_NOT_COMPRESSED = (*DEFAULT_EXCLUDED_CONTENT_TYPES, "application/octet-stream", "application/pdf")

_DESCRIPTION = """Basins of attraction of a rattling gear pair.

Submit a basin, a sweep or an analysis, follow its job, read the result: a summary, a picture, or the Zarr store itself
(`xarray.open_zarr(".../v1/jobs/ID/result.zarr")`). A single motion is computed while the client waits. Time counts
forcing periods; everything else is nondimensional.
"""


def _load_kernels() -> None:
    """Load what outlines and estimates need."""
    with compiled_apart(lambda: None):  # a process that dies with this one
        warm_up_curves()
        for model in ("impacting", "stiff"):
            for together in (True, False):
                measured_speed(model, together)
    # Objects loaded so far stay. The garbage collector would scan them otherwise and delay responses by 150 ms.
    gc.freeze()


def create_app(settings: Settings) -> FastAPI:
    """Application with its database and its runner process, which live as long as it runs.

    Parameters
    ----------
    settings : Settings

    Returns
    -------
    FastAPI
    """

    @contextlib.asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        engine, sessions = open_database(settings.database)
        app.state.jobs = Jobs(sessions, settings.quotas)
        app.state.previews = Previews()
        app.state.checks = RequestChecks()
        app.state.bodies = HeldBodies()
        app.state.large_answers = LargeAnswers()
        app.state.key_ring = KeyRing(Keys(sessions), settings.keys_required)
        app.state.events = Events(sessions)
        app.state.feed = EventFeed(app.state.events)
        app.state.runner = RunnerProcess(settings)
        app.state.probes = Probes(Probe(app.state.jobs.answers, False), app.state.runner.workers)
        app.state.runner.start()
        # Otherwise the first request for an outline would wait for the kernels.
        loading = threading.Thread(target=_load_kernels, name="rattle-kernels", daemon=True)
        loading.start()
        try:
            yield
        finally:
            app.state.feed.close()
            app.state.previews.close()
            app.state.checks.close()
            app.state.large_answers.close()
            await to_thread.run_sync(app.state.runner.stop)
            await to_thread.run_sync(loading.join, _LOADED_SECONDS)
            engine.dispose()

    app = FastAPI(
        title="gear-rattle", version=version("gear-rattle"), description=_DESCRIPTION, lifespan=lifespan,
        license_info={"name": "BSD-3-Clause", "identifier": "BSD-3-Clause"}, docs_url=None, redoc_url=None,
        dependencies=[Depends(refuse_unknown_parameters)],
    )  # fmt: skip
    app.state.settings = settings
    # The middleware added last sees a request first.
    app.add_middleware(Pieces)
    app.add_middleware(
        GZipMiddleware, minimum_size=_LEAST_COMPRESSED, compresslevel=4, exclude_content_types=_NOT_COMPRESSED
    )  # fmt: skip
    app.add_middleware(PlainRequests)
    app.add_middleware(Authentication)
    app.add_middleware(SecurityHeaders)
    app.add_middleware(Access)
    install_error_handlers(app)
    others = [
        each.router for each in (checks, machines, previews, trajectories, jobs, events, results, viewer, health, pages)
    ]
    others += [addition.routes() for addition in additions()]
    others += [kind.routes() for kind in KINDS.values() if kind.routes]
    taken = {route.path for router in others for route in router.routes if isinstance(route, APIRoute)}
    for router in (submit_router(taken), *others):
        app.include_router(router)
    app.mount("/explorer", pages.explorer_files)
    app.mount("/docs", pages.api_page_files)
    app.openapi = lambda: describe(app)  # type: ignore[method-assign]
    return app
