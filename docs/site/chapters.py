"""Which page belongs to which chapter: a folder's README.md is its chapter, and every page beside it is in it.

Pages stay plain Markdown, which a code host shows as well: the tables of contents are added when the site reads them.
Pages come in the order in which the README links them, then those it does not link by name.
"""

import re
import shutil
from pathlib import Path

from sphinx.application import Sphinx

_CHAPTERS = (
    "docs/guide/README",
    "docs/theory/README",
    "docs/explanation/README",
    "docs/paper/README",
    "notebooks/README",
    "docs/api/README",
    "docs/operations/README",
    "docs/decisions/README",
    "docs/performance",
    "docs/benchmarks",
    "CHANGELOG",
    "CONTRIBUTING",
    "SECURITY",
)
_LINK_BESIDE = re.compile(r"\]\(([\w-]+\.(?:md|ipynb))[)#]")


def _pages_of(app: Sphinx, page: str, text: str) -> list[str]:
    """Pages below a page, as their names from the top."""
    if page == app.config.root_doc:
        return list(_CHAPTERS)
    folder, _, name = page.rpartition("/")
    if name != "README":
        return []
    linked = [f"{folder}/{Path(link).stem}" for link in _LINK_BESIDE.findall(text)]
    beside = sorted(each for each in app.env.found_docs if each.rpartition("/")[0] == folder and each != page)
    return list(dict.fromkeys(linked + beside))


def _add_contents(app: Sphinx, page: str, source: list[str]) -> None:
    if pages := _pages_of(app, page, source[0]):
        source[0] += "\n\n```{toctree}\n:hidden:\n\n" + "\n".join(f"/{each}" for each in pages) + "\n```\n"


def _write_index(app: Sphinx, failed: Exception | None) -> None:
    """The page that a server, or a folder, opens first."""
    if failed is None:
        shutil.copyfile(app.outdir / f"{app.config.root_doc}.html", app.outdir / "index.html")


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.connect("source-read", _add_contents)
    app.connect("build-finished", _write_index)
    return {"parallel_read_safe": True}
