"""Long work that Ctrl-C stops cleanly."""

import threading
from collections.abc import Callable
from typing import TypeVar

_T = TypeVar("_T")


def run_interruptibly(work: Callable[[threading.Event], _T]) -> _T:
    """Run work in another thread. Ctrl-C reaches this one, which then sets the event that cancels the work.

    Returns what the work returns, and raises what it raises.
    """
    cancel, ended = threading.Event(), threading.Event()
    results: list[_T] = []
    errors: list[BaseException] = []

    def run() -> None:
        try:
            results.append(work(cancel))
        except BaseException as error:  # handed to the thread that waits
            errors.append(error)
        finally:
            ended.set()

    threading.Thread(target=run).start()
    # Not by joining: Python 3.11 takes a thread for ended once its join has been interrupted.
    try:
        ended.wait()
    except KeyboardInterrupt:
        cancel.set()
        ended.wait()
    if errors:
        raise errors[0]
    return results[0]
