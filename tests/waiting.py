"""Waiting for an event: as long as it can still come, and no number of seconds is chosen."""

import time

_FINAL = ("succeeded", "failed", "cancelled")


def wait_until(what, holds, possible=lambda: None, pause=0.05):
    """What a condition says once it says anything true.

    A busy machine takes its time. The limit of the test (pytest-timeout's, `--timeout`) ends what never comes, and the
    report then says what was waited for.

    Parameters
    ----------
    what : str
        What is waited for, for the report.
    holds : callable
    possible : callable
        Says why it cannot come any more; None while it can.
    """
    try:
        while not (said := holds()):
            impossible = possible()
            assert impossible is None, f"waited until {what}: {impossible}"
            time.sleep(pause)
    except BaseException as error:
        error.add_note(f"This happened while the test waited until {what}.")
        raise
    return said


def ended(job):
    """Whether a job is in one of its last states."""
    return job["state"] in _FINAL
