"""Long work calls a function now and then; an exception raised there stops the work."""

from collections.abc import Callable
from dataclasses import dataclass, field

Pause = Callable[[], None]


def never_stopped() -> None:
    """Do nothing: the pause of work that is never stopped."""


@dataclass(frozen=True)
class Stoppable:
    """A pause that is no part of a cache's key: all are equal.

    Parameters
    ----------
    pause : callable
    """

    pause: Pause = field(compare=False)
