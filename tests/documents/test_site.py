"""The site is built from the pages as they are, needs no network, and is not built from pages with faults."""

import re

import pytest

from tests.documents.site import ROOT, build

FAULTY = """
# A page

[A page](nowhere.md), [a heading](#no-heading)

```{eval-rst}
.. autofunction:: faulty.undocumented
.. autofunction:: faulty.misleading
```
"""
MODULE = '''
def undocumented():
    return 1


def misleading():
    """Do as `nothing_of_this_name`."""
'''
FETCHED = re.compile(r"<(?:script|img|iframe)[^>]*\bsrc=\"https?:|<link[^>]*rel=\"(?:stylesheet|preload)\"[^>]*https?:")


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_the_site_is_built_without_a_warning_and_fetches_nothing(tmp_path):
    done = build(tmp_path)
    assert done.returncode == 0, done.stderr
    pages = sorted((tmp_path / "site").rglob("*.html"))
    assert len(pages) > len(list((ROOT / "docs").rglob("*.md")))
    assert [page for page in pages if FETCHED.search(page.read_text())] == []
    assert [
        style for style in (tmp_path / "site").rglob("*.css") if re.search(r"url\(.?https?:", style.read_text())
    ] == []


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_faults_are_named_and_end_the_build(tmp_path):
    (tmp_path / "README.md").write_text(FAULTY)
    (tmp_path / "faulty.py").write_text(MODULE)
    done = build(tmp_path / "built", source=tmp_path)
    assert done.returncode != 0
    for fault in ("nowhere.md", "no-heading", "faulty.undocumented", "nothing_of_this_name", "no page of docs/api"):
        assert fault in done.stderr
