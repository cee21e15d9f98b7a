"""Which process a replica of the service is, told so that others on the same machine can see whether it still lives.

A lease of a replica that was killed need not run out before its jobs go on: where the replica was a process that this
one would see (same boot, same process namespace) and does not, it is dead.
"""

import os
from functools import cache
from pathlib import Path

_PROC = Path("/proc")


def _start_of(pid: int) -> str | None:
    """When a process was started, in clock ticks since boot: it tells processes of the same number apart."""
    try:
        told = (_PROC / str(pid) / "stat").read_text()
    except OSError:
        return None
    # The name, in parentheses, may hold blanks.
    state, *fields = told.rpartition(")")[2].split()
    return None if state in ("Z", "X") else fields[18]


@cache
def _here() -> str:
    """Machine and process namespace; empty where the system does not tell."""
    try:
        boot = (_PROC / "sys/kernel/random/boot_id").read_text().strip()
        return f"{boot[:13]}.{os.stat(_PROC / 'self/ns/pid').st_ino}"
    except OSError:
        return ""


def replica_name() -> str:
    """Name of this process, unlike any other's: machine, namespace, number, start."""
    return f"{_here()}.{os.getpid()}.{_start_of(os.getpid())}"


def is_dead(name: str) -> bool:
    """Whether a replica is known to have ended; False where that cannot be seen from here."""
    here, pid, start = (name.rsplit(".", 2) + ["", ""])[:3]
    return bool(here) and here == _here() and pid.isdigit() and _start_of(int(pid)) != start
