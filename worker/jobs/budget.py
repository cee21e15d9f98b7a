"""How much processor time the checks of a request may take, where somebody waits for them."""

import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from contextvars import ContextVar

_SPEND: ContextVar[Callable[[], object]] = ContextVar("rattle_check_budget", default=lambda: None)


class CheckTooLong(Exception):
    """The checks of a request take more processor time than they may."""


def spend() -> None:
    """Pass between two checks, or two pieces of values.

    Raises
    ------
    CheckTooLong
        If the budget of `within` is spent, or its event is set.
    """
    _SPEND.get()()


@contextlib.contextmanager
def within(seconds: float, stopped: threading.Event) -> Iterator[None]:
    """Give the checks of this thread a budget.

    Parameters
    ----------
    seconds : float
        Processor time of this thread. Time in which others compute does not count.
    stopped : threading.Event
        Set it to end the checks early.
    """
    begun = time.thread_time()

    def demand() -> None:
        if stopped.is_set() or time.thread_time() - begun > seconds:
            raise CheckTooLong(f"its checks take more than {seconds:g} s of processor time")

    token = _SPEND.set(demand)
    try:
        yield
    finally:
        _SPEND.reset(token)
