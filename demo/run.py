"""Fig. 7 (bottom) of the paper, the way a user would compute it: a service, a request over REST, a store, a picture.

Starts ``rattle serve`` with two workers on a free port, submits demo/request.json, shows progress, copies the result to
demo/basin.zarr and draws demo/basin.png. The service is stopped whatever happens, also when this script is told to stop
or its terminal is closed.
"""

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import httpx2 as httpx

HERE = Path(__file__).parent
RATTLE = str(Path(sys.executable).parent / "rattle")
# The first start compiles the kernels.
START_SECONDS = 120.0


def free_port() -> int:
    """A port that was free a moment ago."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


@contextlib.contextmanager
def service(data: Path) -> Iterator[str]:
    """Address of a service that runs until the context ends."""
    url = f"http://127.0.0.1:{(port := free_port())}"
    # In a group of its own: Ctrl-C reaches this script, which then stops the service in order.
    process = subprocess.Popen([RATTLE, "serve", "--port", str(port), "--data", str(data)], start_new_session=True)
    try:
        wait_until_ready(url, process)
        yield url
    finally:
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(10)
        except (subprocess.TimeoutExpired, KeyboardInterrupt):  # too slow, or Ctrl-C once more
            os.killpg(process.pid, signal.SIGKILL)


def wait_until_ready(url: str, process: subprocess.Popen[bytes]) -> None:
    """Wait until database, scheduler and workers answer."""
    patience = time.monotonic() + START_SECONDS
    while time.monotonic() < patience and process.poll() is None:
        with contextlib.suppress(httpx.TransportError):
            if httpx.get(f"{url}/readyz").status_code == 200:
                return
        time.sleep(0.1)
    raise SystemExit("the service did not start: see what it said above")


def stop_like_ctrl_c(*_: object) -> None:
    """Answer a signal as Ctrl-C is answered, so that what was started is stopped."""
    raise KeyboardInterrupt


def main() -> None:
    """Submit, follow, draw, and keep the store."""
    data = HERE / "data"
    shutil.rmtree(data, ignore_errors=True)
    with service(data) as url:
        begin = time.monotonic()
        if code := subprocess.run([RATTLE, "submit", str(HERE / "request.json"), "--wait", "--url", url]).returncode:
            raise SystemExit(code)
        job = httpx.get(f"{url}/v1/jobs").json()["jobs"][0]
        computed = time.monotonic() - begin
        picture = httpx.get(url + job["links"]["picture"], timeout=60.0)
        (HERE / "basin.png").write_bytes(picture.raise_for_status().content)
        drawn = time.monotonic() - begin
    shutil.rmtree(HERE / "basin.zarr", ignore_errors=True)
    shutil.move(data / "results" / f"{job['id']}.zarr", HERE / "basin.zarr")
    shutil.rmtree(data)
    print(
        f"submit to complete store {computed:.1f} s, to picture {drawn:.1f} s; see demo/basin.png and demo/basin.zarr"
    )


if __name__ == "__main__":
    for asked in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(asked, stop_like_ctrl_c)
    try:
        main()
    except KeyboardInterrupt:
        raise SystemExit("stopped; nothing runs any more") from None
