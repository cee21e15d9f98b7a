"""A browser for all tests, and a page for each, which fails where its console complained."""

import pytest

from tests.browser.chromium import Explorer, browser


@pytest.fixture(scope="session")
def chromium_here():
    with browser() as started:
        yield started


@pytest.fixture
def explorer(chromium_here, service):
    opened = Explorer(chromium_here, service.url)
    yield opened
    opened.context.close()
    assert opened.unforgiven() == []
