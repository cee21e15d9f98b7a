"""Text and JSON are compressed; what is compressed already, and streams, are not."""

import pytest

from tests.service.idle_service import idle_service


@pytest.fixture
def service(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path) as service:
        yield service


@pytest.mark.parametrize("path", ["/openapi.json", "/explorer/js/main.js", "/explorer/explorer.css", "/"])
def test_text_is_compressed_for_clients_that_take_it(service, path):
    answer = service.request("GET", path, headers={"accept-encoding": "gzip"})
    assert answer.headers["content-encoding"] == "gzip" and "accept-encoding" in answer.headers["vary"].lower()
    plain = service.request("GET", path, headers={"accept-encoding": "identity"})
    assert "content-encoding" not in plain.headers and plain.text == answer.text
    assert int(answer.headers["content-length"]) < len(plain.content) / 2


def test_pictures_and_short_answers_are_not(service):
    for path in ("/explorer/thumbnails/fig12.png", "/healthz"):
        answer = service.request("GET", path, headers={"accept-encoding": "gzip"})
        assert answer.status_code == 200 and "content-encoding" not in answer.headers
