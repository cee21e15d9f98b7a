"""Uvicorn with its own limits. It ends streams when the service stops."""

import socket

import uvicorn
from fastapi import FastAPI

from service.settings import Settings

_STOP_SECONDS = 2
_HEAD_BYTES = 65_536


class Server(uvicorn.Server):
    """A server of one application.

    It bounds the heads of requests and the number of connections. Clients that send or read slowly are the proxy's
    task: see `docs/operations.md`.

    Parameters
    ----------
    app : FastAPI
    settings : Settings
    """

    def __init__(self, app: FastAPI, settings: Settings) -> None:
        super().__init__(
            uvicorn.Config(
                app, host=settings.host, port=settings.port, ws="none", lifespan="on",
                # The parser that bounds heads, chunk headers and trailers; httptools keeps whatever is sent.
                http="h11", h11_max_incomplete_event_size=_HEAD_BYTES, limit_concurrency=settings.max_connections,
                log_config=None, access_log=False, server_header=False, proxy_headers=False,
                timeout_graceful_shutdown=_STOP_SECONDS,
            )
        )  # fmt: skip
        self._app = app

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Stop. Event streams end first; their clients reconnect and continue where they were."""
        self._app.state.feed.close()
        await super().shutdown(sockets)
