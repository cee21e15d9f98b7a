"""Names of the service's replicas. Others on the same machine can tell from a name whether the replica is alive.

A replica is dead if it ran on this machine, since the same boot and in the same process namespace, and its process is
gone. Its jobs then continue before their leases run out.
"""

import os
from contextlib import suppress
from functools import cache
from pathlib import Path

import psutil

_PROC = Path("/proc")


def _start_of(pid: int) -> int | None:
    """Seconds from boot to the start of a process, which distinguish reused process numbers; None if it is gone.

    `psutil` adds the kernel's time of boot, which moves when the system's clock is set. The difference does not.
    """
    with suppress(psutil.NoSuchProcess):
        process = psutil.Process(pid)
        if process.status() not in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD):
            return round(process.create_time() - psutil.boot_time())
    return None


@cache
def _here() -> str:
    """Machine and process namespace; empty if the system does not provide them."""
    try:
        boot = (_PROC / "sys/kernel/random/boot_id").read_text().strip()
        return f"{boot[:13]}.{os.stat(_PROC / 'self/ns/pid').st_ino}"
    except OSError:
        return ""


def replica_name() -> str:
    """Unique name of this process: machine, namespace, process number, start."""
    return f"{_here()}.{os.getpid()}.{_start_of(os.getpid())}"


def is_dead(name: str) -> bool:
    """Whether a replica is known to have ended; False if this machine cannot know."""
    here, pid, start = (name.rsplit(".", 2) + ["", ""])[:3]
    if not here or here != _here() or not pid.isdigit():
        return False
    running = _start_of(int(pid))
    # The kernel's time of boot may change by a second between the two readings.
    return running is None or abs(running - int(start)) > 1
