"""What keeps a driver from writing that has lost its job to another one."""

from collections.abc import Callable

Fence = Callable[[], None]
"""Called before everything that only the driver writes: raises `LeaseLost` where the job is another driver's by now."""


def unfenced() -> None:
    """The fence of a driver that nobody can take a job from."""
