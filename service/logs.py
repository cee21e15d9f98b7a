"""Log lines that name the job they are about: plain text, or one JSON object a line."""

import atexit
import contextlib
import contextvars
import json
import logging
import queue
from collections.abc import Iterator
from datetime import UTC, datetime
from enum import StrEnum
from logging.handlers import QueueHandler, QueueListener

_job: contextvars.ContextVar[str | None] = contextvars.ContextVar("job", default=None)
ACCESS_LOG = "rattle.access"
_FIELDS = ("method", "path", "status", "milliseconds", "key", "client")


class LogFormat(StrEnum):
    """Format of the log lines."""

    PLAIN = "plain"
    JSON = "json"


@contextlib.contextmanager
def about_job(job_id: str) -> Iterator[None]:
    """Mark everything that this thread logs within the context as being about a job."""
    token = _job.set(job_id)
    try:
        yield
    finally:
        _job.reset(token)


class _Plain(logging.Formatter):
    def __init__(self) -> None:
        super().__init__("%(asctime)s %(levelname)s %(name)s: %(message)s")

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802
        job = _job.get()
        return super().formatMessage(record) + (f" [job {job}]" if job else "")


class _Json(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        line = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "logger": record.name,
            "message": record.getMessage(),
            "job": _job.get(),
        }
        line |= {field: getattr(record, field) for field in _FIELDS if hasattr(record, field)}
        if record.exc_info:
            line["traceback"] = self.formatException(record.exc_info)
        return json.dumps({name: value for name, value in line.items() if value is not None})


def write_logs(form: LogFormat, level: str) -> QueueListener:
    """Write this service's log to standard error, from a thread of its own: the event loop does not wait for it.

    Parameters
    ----------
    form : LogFormat
    level : str
        Lowest level of the service's own lines. Libraries log warnings and errors.

    Returns
    -------
    QueueListener
        The thread. It stops when the interpreter exits. Code that calls `os._exit` must stop it first.
    """
    handler = QueueHandler(queue.SimpleQueue())
    # Lines are formatted in the thread that logs them, which knows its job.
    handler.setFormatter(_Json() if form is LogFormat.JSON else _Plain())
    logging.basicConfig(handlers=[handler], level=logging.WARNING, force=True)
    logging.getLogger("rattle").setLevel(level.upper())
    # Malformed HTTP from a client gets an error response. It is no fault of the service.
    logging.getLogger("uvicorn.error").setLevel(logging.ERROR)
    listener = QueueListener(handler.queue, logging.StreamHandler())
    listener.start()
    atexit.register(listener.stop)
    return listener
