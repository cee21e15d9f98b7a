"""The page of the API needs nothing but the service."""

import re
from pathlib import Path

import pytest
import yaml

from tests.service.idle_service import idle_service
from worker.kinds import KINDS


@pytest.fixture
def service(monkeypatch, tmp_path):
    with idle_service(monkeypatch, tmp_path) as service:
        yield service


def test_the_page_and_all_that_it_loads_come_from_the_service(service):
    page = service.request("GET", "/docs")
    loaded = re.findall(r'(?:src|href)="([^"]+)"', page.text)
    assert page.status_code == 200 and len(loaded) >= 5
    assert not [address for address in loaded if "//" in address]
    for address in loaded:
        assert service.request("GET", f"/{address}").status_code == 200, address
    assert "https:" not in page.headers["content-security-policy"]


def test_its_files_are_swagger_uis_under_its_licence(service):
    bundle, style = (service.request("GET", f"/docs/swagger-ui{end}").text for end in ("-bundle.js", ".css"))
    assert "SwaggerUIBundle" in bundle[:1000] and ".swagger-ui" in style
    assert "Apache License" in service.request("GET", "/docs/swagger-ui.LICENSE").text
    assert not re.search(r"url\(\s*[\"']?https?:|@import", style)


def test_the_explorer_is_told_all_kinds_with_their_routes(service):
    kinds = service.request("GET", "/explorer/kinds.json").json()
    assert list(kinds) == list(KINDS) and all(kind["title"] for kind in kinds.values())
    routes = service.request("GET", "/openapi.json").json()["paths"]
    assert all("post" in routes[kind["path"]] for kind in kinds.values())


def test_the_explorer_is_told_what_a_caption_cites(service):
    cited = service.request("GET", "/explorer/citation.json").json()
    known = yaml.safe_load((Path(__file__).parents[3] / "CITATION.cff").read_text())
    (paper,) = (each for each in known["references"] if each["type"] == "article")
    assert cited["program"] == f"{known['title']} {known['version']}"
    assert paper["doi"] in cited["paper"] and paper["title"] in cited["paper"] and str(paper["year"]) in cited["paper"]


def test_the_pages_take_addresses_that_hold_what_is_seen(service):
    assert service.request("GET", "/?job=0123&window=0,1").status_code == 200
    assert service.request("GET", "/docs?x=1").status_code == 200
