"""The documentation site in a browser that has no network: search, formulas, and pages as narrow as a telephone."""

import pytest
from playwright.sync_api import expect

from tests.documents.site import build

PAGES = (
    "index", "docs/theory/model", "docs/paper/gallery", "docs/operations/README", "docs/api/rattle_kernels",
    "docs/api/http", "docs/api/shell", "notebooks/anatomy",
)  # fmt: skip
pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("built")
    done = build(target=folder)
    assert done.returncode == 0, done.stderr
    return (folder / "site").as_uri()


@pytest.fixture
def offline(chromium_here):
    context = chromium_here.new_context(offline=True, viewport={"width": 360, "height": 800})
    yield context.new_page()
    context.close()


def test_search_finds_functions_and_pages(site, offline):
    offline.goto(f"{site}/search.html?q=grazing_velocity")
    found = offline.locator("#search-results")
    expect(found).to_contain_text("rattle_kernels.grazing_velocity")
    expect(found).to_contain_text("Measures of a basin picture")


@pytest.mark.parametrize("page", PAGES)
def test_no_page_is_wider_than_a_telephone_or_asks_for_anything(site, offline, page):
    asked = []
    offline.on("request", lambda request: asked.append(request.url))
    offline.goto(f"{site}/{page}.html")
    for part in ("html", ".bd-article-container"):
        assert offline.locator(part).evaluate("part => part.scrollWidth - part.clientWidth") <= 0
    assert [url for url in asked if not url.startswith(("file:", "data:"))] == []
    broken = "images => images.filter(image => image.complete && image.naturalWidth === 0).length"
    assert offline.locator("article img").evaluate_all(broken) == 0


def test_formulas_are_drawn(site, offline):
    offline.goto(f"{site}/docs/theory/model.html")
    box = offline.locator("math").first.bounding_box()
    assert box["width"] > 200 and box["height"] > 10
