"""The FastAPI application: what it holds while it runs, and its routes."""

import contextlib
from collections.abc import AsyncIterator
from importlib.metadata import version

from anyio import to_thread
from fastapi import FastAPI

from service.body_limit import BodyLimit
from service.database import open_database
from service.errors import install_error_handlers
from service.jobs import Jobs
from service.routes import analyses, basins, health, jobs, results, sweeps, trajectories
from service.runner import Runner
from service.settings import Settings
from worker.cluster import connect

_DESCRIPTION = """Basins of attraction of a rattling gear pair.

Submit a basin, a sweep or an analysis, follow its job, read the result: a summary, a picture, or the Zarr store itself
(`xarray.open_zarr(".../v1/jobs/ID/result.zarr")`). A single motion is answered at
once. Time counts forcing periods; everything else is nondimensional.
"""


def create_app(settings: Settings) -> FastAPI:
    """Application with its database, cluster and runner, which live as long as it runs.

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
        stack = contextlib.ExitStack()
        stack.callback(engine.dispose)
        client = await to_thread.run_sync(stack.enter_context, connect(settings.scheduler, settings.workers))
        app.state.jobs = Jobs(sessions)
        app.state.runner = Runner(app.state.jobs, client, settings.results)
        app.state.runner.start()
        try:
            yield
        finally:
            await to_thread.run_sync(app.state.runner.stop)
            await to_thread.run_sync(stack.close)

    app = FastAPI(
        title="gear-rattle", version=version("gear-rattle"), description=_DESCRIPTION, lifespan=lifespan,
        license_info={"name": "BSD-3-Clause", "identifier": "BSD-3-Clause"},
    )  # fmt: skip
    app.state.settings = settings
    app.add_middleware(BodyLimit, most=settings.max_body_bytes)
    install_error_handlers(app)
    for router in (
        basins.router,
        sweeps.router,
        analyses.router,
        trajectories.router,
        jobs.router,
        results.router,
        health.router,
    ):
        app.include_router(router)
    return app
