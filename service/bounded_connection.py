"""HTTP connections that hold a bounded part of the service's memory, however much a client sends.

Uvicorn's fast parser keeps heads, trailers and waiting requests without limit. Its other parser limits them, but is
written in Python: at 300 requests a second it leaves no time for anything else (decision 27).
"""

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

_HEAD_BYTES = 65_536
# Requests that a client sends before it reads the first answer.
_WAITING_REQUESTS = 64


class BoundedConnection(HttpToolsProtocol):
    """A connection that ends with status 400 when what is not a body exceeds 64 KiB, or when too many requests wait."""

    _not_body = 0

    def data_received(self, data: bytes) -> None:
        """Parse what has come. A head ends within its limit, or the connection does."""
        if self.transport.is_closing():
            return
        self._not_body += len(data)
        super().data_received(data)
        # Counted after parsing, because a body may come in the same piece as its head.
        if self._not_body > _HEAD_BYTES or len(self.pipeline) > _WAITING_REQUESTS:
            self.send_400_response("A head, chunk header or trailer is too large, or too many requests wait.")

    def on_body(self, body: bytes) -> None:
        """Take a part of a body."""
        self._not_body = 0
        super().on_body(body)

    def on_message_complete(self) -> None:
        """End a request."""
        self._not_body = 0
        super().on_message_complete()
