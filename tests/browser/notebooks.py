"""Servers of notebooks, each in a process of its own, with nothing of the user's."""

import contextlib
import json
import os
import subprocess
import sys

import httpx2 as httpx

from rattle_kernels.numerics.jit import cache_folder
from tests.ports import free_port
from tests.waiting import wait_until


@contextlib.contextmanager
def running(arguments, folder, ready):
    """Run a server below a folder until the context ends; `ready` is the path that answers when it is."""
    port = free_port()
    address = f"http://127.0.0.1:{port}"
    own = {f"JUPYTER_{name}_DIR": str(folder / name.lower()) for name in ("CONFIG", "DATA", "RUNTIME")}
    own |= {"HOME": str(folder), "NUMBA_CACHE_DIR": str(cache_folder().parents[1])}
    log = folder / "server.log"
    with log.open("w") as told:
        process = subprocess.Popen(
            [sys.executable, *(each.format(port=port) for each in arguments)], cwd=folder, stdout=told,
            stderr=subprocess.STDOUT, env=os.environ | own,
        )  # fmt: skip
    try:
        wait_until(
            f"{address}{ready} answers, see {log}", lambda: _answers(address + ready), lambda: _ended(process, log)
        )
        yield address
    finally:
        process.terminate()
        process.wait(30)


def _answers(address):
    with contextlib.suppress(httpx.TransportError):
        return httpx.get(address, timeout=5.0).status_code == 200
    return False


def _ended(process, log):
    return None if process.poll() is None else f"it has ended with {process.returncode}: {log.read_text()}"


def write_notebook(path, *cells):
    """Write a Jupyter notebook with these cells."""
    written = [
        {
            "cell_type": "code",
            "id": f"cell-{i}",
            "source": source,
            "metadata": {},
            "outputs": [],
            "execution_count": None,
        }
        for i, source in enumerate(cells)
    ]
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    path.write_text(json.dumps({"cells": written, "metadata": kernel, "nbformat": 4, "nbformat_minor": 5}))
