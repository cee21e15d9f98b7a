"""Long work pauses now and then, so that whoever wants it to stop can raise an exception there."""

from collections.abc import Callable

Pause = Callable[[], None]


def never_stopped() -> None:
    """The pause of work that nobody stops."""
