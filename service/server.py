"""Uvicorn, with connections that are bounded and streams that end when the service stops."""

import socket
from functools import partial

import uvicorn
from fastapi import FastAPI

from service.middleware.bounded_connection import BoundedConnection, Bounds
from service.settings import Settings

_STOP_SECONDS = 2


class Server(uvicorn.Server):
    """A server of one application.

    Parameters
    ----------
    app : FastAPI
    settings : Settings
    """

    def __init__(self, app: FastAPI, settings: Settings) -> None:
        bounds = Bounds(settings.max_connections, settings.request_seconds, settings.max_body_bytes)
        super().__init__(
            uvicorn.Config(
                app, host=settings.host, port=settings.port, ws="none", lifespan="on",
                http=partial(BoundedConnection, bounds),  # type: ignore[arg-type]
                log_config=None, access_log=False, server_header=False, proxy_headers=False,
                timeout_graceful_shutdown=_STOP_SECONDS,
            )
        )  # fmt: skip
        self._app = app

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Stop; streams of events end first, and their clients come back with where they were."""
        self._app.state.feed.close()
        await super().shutdown(sockets)
