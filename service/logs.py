"""Log lines that name the job they are about: plain text, or one JSON object a line."""

import atexit
import contextlib
import contextvars
import json
import logging
import queue
import threading
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


class _Forwarding(logging.StreamHandler):
    """Hands records to the service's own handler. Dask silences its loggers by the level of their stream handlers."""

    def emit(self, record: logging.LogRecord) -> None:
        for handler in logging.getLogger().handlers:
            handler.handle(record)


def _gather() -> None:
    """Let every logger that a library gave a stream of its own write through the service's handler, warnings as well.

    What ends a thread is logged, too.
    """
    for logger in list(logging.Logger.manager.loggerDict.values()):
        if isinstance(logger, logging.Logger) and any(type(each) is logging.StreamHandler for each in logger.handlers):
            forwarding = _Forwarding()
            forwarding.setLevel(logging.WARNING)
            logger.handlers[:] = [forwarding]
            logger.propagate = False
    logging.captureWarnings(True)
    threading.excepthook = _log_of_thread


def _log_of_thread(ended: threading.ExceptHookArgs) -> None:
    if ended.exc_value is None or isinstance(ended.exc_value, SystemExit):
        return
    name = ended.thread.name if ended.thread else "unknown"
    why = (ended.exc_type, ended.exc_value, ended.exc_traceback)
    logging.getLogger("rattle.service").error("the thread %s has ended", name, exc_info=why)


def write_logs(form: LogFormat, level: str) -> QueueListener:
    """Write the log of this process to standard error: of the service and of every library, and Python's warnings.

    A thread of its own writes it: the event loop does not wait for it.

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
    _gather()
    listener = QueueListener(handler.queue, logging.StreamHandler())
    listener.start()
    atexit.register(listener.stop)
    return listener
