"""What the first answers would wait for, done before anyone asks: kernels that run in this process, not in workers'."""

import threading

from rattle_kernels import Oscillator, grazing_velocity, time_history

_STOP_SECONDS = 2.0


class FirstAnswers:
    """A thread that loads the kernels of outlines and time histories: a third of a second, the first time ten."""

    def __init__(self) -> None:
        self._thread = threading.Thread(target=_prepare, name="rattle-first-answers", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """Wait for the end, though not for long."""
        self._thread.join(_STOP_SECONDS)


def _prepare() -> None:
    grazing_velocity(Oscillator(), 0.0)
    time_history(Oscillator(), 0.0, 0.0, 0.0, periods=1.0)
