"""HTTP connections that hold a bounded part of the service's memory, however much a client sends.

Uvicorn's fast parser keeps heads, trailers and waiting requests without limit. Its other parser limits them, but is
written in Python: at 300 requests a second it leaves no time for anything else (decision 27).
"""

from typing import Any

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

_HEAD_BYTES = 65_536
# Requests that a client sends before it reads the first answer.
_WAITING_REQUESTS = 64
# Between a header's name and its value, and after it.
_AROUND_A_HEADER = len(": \r\n")


class BoundedConnection(HttpToolsProtocol):
    """A connection that ends with status 400 when what is not a body exceeds 64 KiB, or when too many requests wait."""

    _not_body = _head = 0
    _answering: Any = None

    def data_received(self, data: bytes) -> None:
        """Parse what has come. A head ends within its limit, or the connection does."""
        if self.transport.is_closing():
            return
        self._not_body += len(data)
        super().data_received(data)
        # Counted after parsing, because a body may come in the same piece as its head.
        if self._not_body > _HEAD_BYTES or len(self.pipeline) > _WAITING_REQUESTS:
            self.send_400_response("")

    def on_message_begin(self) -> None:
        """Begin a request."""
        self._head = 0
        super().on_message_begin()

    def on_url(self, url: bytes) -> None:
        """Take a part of the address."""
        self._count_head(len(url))
        super().on_url(url)

    def on_header(self, name: bytes, value: bytes) -> None:
        """Take a header."""
        self._count_head(len(name) + len(value) + _AROUND_A_HEADER)
        super().on_header(name, value)

    def _count_head(self, size: int) -> None:
        self._head += size
        if self._head > _HEAD_BYTES:
            raise ValueError("a head is too large")  # the parser ends, and with it the connection

    def on_body(self, body: bytes) -> None:
        """Take a part of a body."""
        self._not_body = 0
        super().on_body(body)

    def on_message_complete(self) -> None:
        """End a request."""
        self._not_body = 0
        super().on_message_complete()

    def send_400_response(self, msg: str) -> None:
        """Refuse a request and close the connection. Requests that wait on it are dropped."""
        if self.transport.is_closing():
            return
        begun = self._answering is not None and self._answering.response_started
        self._give_up()
        if begun:
            self.transport.close()  # no second answer within the one that is being sent
        else:
            super().send_400_response(_REFUSAL if self._head > _HEAD_BYTES or not msg else msg)

    def connection_lost(self, exc: Exception | None) -> None:
        """End with the connection all requests that came on it, and not only the last one."""
        self._give_up()
        super().connection_lost(exc)

    def _start_asgi_task(self, cycle: Any, app: Any) -> None:
        self._answering = cycle
        super()._start_asgi_task(cycle, app)

    def _give_up(self) -> None:
        """Send no more of the answer that is being made."""
        self.pipeline.clear()
        if (cycle := self._answering) is not None and not cycle.response_complete:
            cycle.disconnected = True
            cycle.message_event.set()


_REFUSAL = "A head, chunk header or trailer is too large, or too many requests wait."
