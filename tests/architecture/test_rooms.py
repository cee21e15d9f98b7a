"""A stranger finds what he looks for: links that lead somewhere."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FACE = ROOT / "rattle_kernels" / "__init__.py"
KERNELS = sorted(path for path in FACE.parent.rglob("*.py") if path != FACE)
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").rglob("*.md")])


def named(paths):
    paths = list(paths)
    return {"argvalues": paths, "ids": [str(path.relative_to(ROOT)) for path in paths]}


def links(page):
    return re.findall(r"\]\(([^)#\s]+)", page.read_text())


def files(page):
    return re.findall(r"`((?:tests|docs|worker|service|rattle_kernels|rattle_proof)/[\w/.-]+)`", page.read_text())


@pytest.mark.parametrize("page", **named(filter(links, PAGES)))
def test_links_of_a_page_lead_somewhere(page):
    for target in links(page):
        assert "://" in target or (page.parent / target).exists(), target


@pytest.mark.parametrize("page", **named(filter(files, PAGES)))
def test_files_that_a_page_names_are_there(page):
    for name in files(page):
        assert (ROOT / name).exists(), name


@pytest.mark.parametrize("path", **named(KERNELS))
def test_the_kernels_do_not_import_their_own_face(path):
    assert not re.search(r"^\s*(from rattle_kernels import|import rattle_kernels$)", path.read_text(), re.MULTILINE)
