"""Fig. 7 (bottom) of the paper, the way a user would compute it: a service, a request over REST, a store, a picture.

Compiles the kernels where they are not compiled yet, starts ``rattle serve`` with two workers on a free port, submits
demo/request.json, shows tiles as they land, moves the result to demo/basin.zarr and draws demo/basin.png. What the
service logs is in demo/service.log. The service is stopped whatever happens, also when this script is told to stop or
its terminal is closed.
"""

import argparse
import collections
import contextlib
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import httpx2 as httpx

from rattle.cli.console import out, progress_line
from rattle.cli.result_tables import print_result
from rattle.progress import ProgressLine
from rattle.remote.failure import ServiceFailed
from rattle.remote.job import RemoteJob
from rattle.remote.service import Service
from rattle_kernels import warm_up

HERE = Path(__file__).parent
RATTLE = [sys.executable, "-c", "from rattle.cli import main; main()"]
READY = "ready: "
# Seconds, but for a machine that is busy with other work.
START_SECONDS = 300.0
LAST_LINES = 20


@contextlib.contextmanager
def service(data: Path, log: Path) -> Iterator[str]:
    """Address of a service that runs until the context ends."""
    command = [*RATTLE, "serve", "--port", "0", "--data", str(data)]
    with log.open("w") as lines:
        # In a group of its own: Ctrl-C reaches this script, which then stops the service in order.
        process = subprocess.Popen(command, start_new_session=True, stdout=subprocess.PIPE, stderr=lines, text=True)
    try:
        yield address_when_ready(process, log)
    finally:
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(10)
        except (subprocess.TimeoutExpired, KeyboardInterrupt):  # too slow, or Ctrl-C once more
            os.killpg(process.pid, signal.SIGKILL)


def address_when_ready(process: subprocess.Popen[str], log: Path) -> str:
    """Where a service is, read from the line by which it says that database, scheduler and workers answer."""
    impatience = threading.Timer(START_SECONDS, process.kill)
    impatience.start()
    try:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith(READY):
                return line.removeprefix(READY).partition(",")[0]
    finally:
        impatience.cancel()
    with log.open() as lines:
        said = "".join(collections.deque(lines, LAST_LINES))
    raise SystemExit(f"{said}the service did not start; its log is {log}")


def computed(url: str, request: Path, line: ProgressLine) -> RemoteJob:
    """The job of a request, when it has succeeded."""
    try:
        job = Service(url).submit_text(request.read_text())
        job.follow(line)
        job.demand_success()
    except ServiceFailed as error:
        raise SystemExit(str(error)) from error
    return job


def from_here(path: Path) -> str:
    """A path as one types it here."""
    relative = os.path.relpath(path)
    return str(path) if relative.startswith("..") else relative


def stop_like_ctrl_c(*_: object) -> None:
    """Answer a signal as Ctrl-C is answered, so that what was started is stopped."""
    raise KeyboardInterrupt


def main(request: Path, folder: Path) -> None:
    """Submit, follow, draw, keep the store, and say what to do with all this."""
    data, store, picture, log = (folder / name for name in ("data", "basin.zarr", "basin.png", "service.log"))
    shutil.rmtree(data, ignore_errors=True)
    with progress_line() as line:
        # Before the service starts, which would do it without a word here.
        warm_up(line.compiling)
        out.print(f"starting a service with two workers; its log is {from_here(log)}", highlight=False, soft_wrap=True)
        with service(data, log) as url:
            out.print(f"ready on {url}; computing the basins of {from_here(request)}", highlight=False, soft_wrap=True)
            begin = time.monotonic()
            job = computed(url, request, line)
            seconds = time.monotonic() - begin
            result = job.result()
            drawn = httpx.get(url + job.described["links"]["picture"], timeout=60.0)
            picture.write_bytes(drawn.raise_for_status().content)
    shutil.rmtree(store, ignore_errors=True)
    shutil.move(data / "results" / f"{job.id}.zarr", store)
    shutil.rmtree(data)
    print_result("basin", result)
    opener = "open" if sys.platform == "darwin" else "xdg-open"
    look = f"import xarray; print(xarray.open_zarr({from_here(store)!r}))"
    for text in (
        f"from request to complete store: {seconds:.1f} s",
        f"picture: {from_here(picture)}",
        f"  {opener} {from_here(picture)}",
        f"store:   {from_here(store)}",
        f'  {from_here(Path(sys.executable))} -c "{look}"',
        "next:    make serve",
        "  then open http://127.0.0.1:8000, choose an example of the paper and press Compute",
    ):
        out.print(text, markup=False, highlight=False, soft_wrap=True)


if __name__ == "__main__":
    options = argparse.ArgumentParser(description="Compute a basin through a service of its own.")
    options.add_argument("--request", type=Path, default=HERE / "request.json", help="JSON file of a basin's request")
    options.add_argument("--out", type=Path, default=HERE, help="folder of the store, the picture and the log")
    given = options.parse_args()
    for asked in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(asked, stop_like_ctrl_c)
    try:
        main(given.request, given.out)
    except KeyboardInterrupt:
        raise SystemExit("stopped; nothing runs any more") from None
