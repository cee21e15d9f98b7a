"""An S3 server in a process of its own: moto's, on loopback."""

import contextlib
import os
import subprocess
import sys
import urllib.error
import urllib.request

import obstore
from obstore.store import S3Store

from tests.ports import free_port
from tests.waiting import wait_until

BUCKET = "results"


class ObjectStore:
    """Where it is, and the variables by which stores find it; `on` makes a command one that is run on another host."""

    def __init__(self, host="127.0.0.1", port=None, on=list):
        self.host, self.port, self._on = host, port or free_port(), on
        self.variables = {
            "AWS_ENDPOINT_URL": f"http://{self.host}:{self.port}",
            "AWS_ACCESS_KEY_ID": "tests",
            "AWS_SECRET_ACCESS_KEY": "no secret",
        }
        self.process = None

    def start(self):
        """Start it, with an empty bucket."""
        command = [sys.executable, "-W", "ignore", "-m", "moto.server", "-H", self.host, "-p", str(self.port)]
        self.process = subprocess.Popen(self._on(command), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        make_bucket(self.variables["AWS_ENDPOINT_URL"], self._why_not)

    def _why_not(self):
        """Why it will never answer; None while its process lives."""
        code = self.process.poll()
        return None if code is None else f"it has ended with {code}"

    def kill(self):
        """End it at once; what it held is gone."""
        self.process.kill()
        self.process.wait(10)

    def objects(self, prefix=""):
        """Content by path of all objects below a prefix of the bucket."""
        store = S3Store(BUCKET, prefix=prefix or None, **self.settings())
        paths = [found["path"] for batch in obstore.list(store) for found in batch]
        return {path: bytes(obstore.get(store, path).bytes()) for path in paths}

    def settings(self):
        """The same for obstore."""
        return {
            "endpoint": self.variables["AWS_ENDPOINT_URL"], "access_key_id": "tests", "secret_access_key": "no secret",
            "region": "us-east-1", "client_options": {"allow_http": True},
        }  # fmt: skip


def make_bucket(endpoint, why_not=lambda: None):
    """Make the bucket, once the server answers; `why_not` says why it never will."""
    request = urllib.request.Request(f"{endpoint}/{BUCKET}", method="PUT")

    def made():
        with contextlib.suppress(urllib.error.URLError, OSError):
            urllib.request.urlopen(request, timeout=5).close()
            return True

    wait_until(f"an S3 server answers at {endpoint}", made, why_not)


@contextlib.contextmanager
def running_object_store():
    """Run an S3 server; this process and those that it starts find it by their environment until the context ends."""
    store = ObjectStore()
    before = dict(os.environ)
    os.environ.update(store.variables)
    try:
        store.start()
        yield store
    finally:
        store.kill()
        os.environ.clear()
        os.environ.update(before)
