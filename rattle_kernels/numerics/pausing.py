"""Long work calls a function now and then; an exception raised there stops the work."""

from collections.abc import Callable

Pause = Callable[[], None]


def never_stopped() -> None:
    """Do nothing: the pause of work that is never stopped."""
