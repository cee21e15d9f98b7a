"""Fetching a result from a service that fails in the middle: no copy with holes gets the name that was asked for."""

import http.server
import io
import threading

import pytest
from rich.console import Console

import rattle
from rattle.remote.failure import ServiceFailed
from rattle.remote.fetching import fetch_store

CHUNK, METADATA = "/solution/c/0/0", "/solution/zarr.json"


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    folder = tmp_path_factory.mktemp("theirs") / "basin.zarr"
    rattle.basin(cells=12, iterations=61, store=folder, progress=False)
    return folder


@pytest.fixture
def failing(store):
    """Serve the store; `answers[path]` is a status to answer with, or None for a connection that is cut."""
    answers, seen = {}, []

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):  # noqa: N802 - as http.server calls it
            seen.append(self.path)
            file = store / self.path.lstrip("/")
            status = answers[self.path] if self.path in answers else 200 if file.is_file() else 404
            if callable(status):
                status = status(seen.count(self.path))
            if status is None:  # half of an answer
                self.send_response(200)
                self.send_header("content-length", "1000")
                self.end_headers()
                self.wfile.write(b"half")
                return
            content = file.read_bytes() if status == 200 else b"it broke"
            self.send_response(status)
            self.send_header("content-length", str(len(content)))
            self.end_headers()
            self.wfile.write(content)

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}", answers
    server.shutdown()
    thread.join()
    server.server_close()


def fetch(url, folder):
    fetch_store(url, {}, folder, Console(file=io.StringIO()))


def test_a_store_without_failures_is_copied(failing, store, tmp_path):
    url, _ = failing
    fetch(url, tmp_path / "copy.zarr")
    files = [path.relative_to(store) for path in store.rglob("*") if path.is_file()]
    assert all((tmp_path / "copy.zarr" / path).read_bytes() == (store / path).read_bytes() for path in files)


@pytest.mark.parametrize("status", [500, 503, 429, 401, 403, 410, None])
@pytest.mark.parametrize("path", [CHUNK, METADATA, "/zarr.json"])
def test_no_error_counts_as_a_file_that_is_not_there(failing, tmp_path, status, path):
    url, answers = failing
    answers[path] = status
    with pytest.raises(ServiceFailed):
        fetch(url, tmp_path / "copy.zarr")
    assert list(tmp_path.iterdir()) == [], "neither the copy nor a part of it"


def test_metadata_that_the_root_lists_must_be_there(failing, tmp_path):
    url, answers = failing
    answers[METADATA] = 404
    with pytest.raises(ServiceFailed, match="solution/zarr.json"):
        fetch(url, tmp_path / "copy.zarr")
    assert list(tmp_path.iterdir()) == []


def test_a_result_that_is_deleted_meanwhile_has_no_holes_instead(failing, tmp_path):
    """From some file on every answer is 404: chunks without a file look the same, but the root is gone as well."""
    url, answers = failing
    answers |= {CHUNK: 404, "/zarr.json": lambda asked: 200 if asked == 1 else 404}
    with pytest.raises(ServiceFailed, match="deleted"):
        fetch(url, tmp_path / "copy.zarr")
    assert list(tmp_path.iterdir()) == []
