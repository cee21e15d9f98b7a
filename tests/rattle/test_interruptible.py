"""Ctrl-C lets work end in order."""

import signal
import threading
import time

import pytest

from rattle.local import run_interruptibly


@pytest.fixture
def interruptible():
    """Ctrl-C interrupts, also where the tests were started by a shell in the background, which has it ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_cancels_the_work_and_waits_until_it_has_ended():
    main = threading.main_thread()

    def work(cancel):
        assert threading.current_thread() is not main
        time.sleep(1.0)  # until the other thread waits
        signal.pthread_kill(main.ident, signal.SIGINT)
        assert cancel.wait(10.0)
        time.sleep(0.3)  # what is left to put in order
        return "in order"

    assert run_interruptibly(work) == "in order"


def test_what_work_raises_is_raised_here():
    def work(cancel):
        raise ValueError("of its own")

    with pytest.raises(ValueError, match="of its own"):
        run_interruptibly(work)
