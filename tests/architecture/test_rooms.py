"""A stranger finds what he looks for: few modules in a folder, short files, links that lead somewhere."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("rattle_kernels", "worker", "service", "rattle", "tests")
MOST_MODULES, MOST_LINES, README_LINES = 14, 300, 100
FOLDERS = sorted({path.parent for package in PACKAGES for path in (ROOT / package).rglob("*.py")})
CODE = sorted(path for package in PACKAGES[:-1] for path in (ROOT / package).rglob("*.py"))
PAGES = sorted([ROOT / "README.md", *(ROOT / "docs").rglob("*.md")])


def named(paths):
    return {"argvalues": paths, "ids": [str(path.relative_to(ROOT)) for path in paths]}


@pytest.mark.parametrize("folder", **named(FOLDERS))
def test_a_folder_holds_few_modules(folder):
    modules = [path for path in folder.glob("*.py") if path.name != "__init__.py"]
    assert len(modules) <= MOST_MODULES


@pytest.mark.parametrize("path", **named(CODE))
def test_a_file_is_short(path):
    assert len(path.read_text().splitlines()) <= MOST_LINES


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_text().splitlines()) <= README_LINES


@pytest.mark.parametrize("page", **named(PAGES))
def test_links_of_a_page_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#\s]+)", page.read_text()):
        assert "://" in target or (page.parent / target).exists(), target


@pytest.mark.parametrize("page", **named(PAGES))
def test_files_that_a_page_names_are_there(page):
    for name in re.findall(r"`((?:tests|docs|worker|service|rattle_kernels)/[\w/.-]+)`", page.read_text()):
        assert (ROOT / name).exists(), name


@pytest.mark.parametrize("path", **named([path for path in CODE if path.parent != ROOT / "rattle_kernels"]))
def test_the_kernels_do_not_import_their_own_face(path):
    if path.is_relative_to(ROOT / "rattle_kernels"):
        assert not re.search(r"^\s*from rattle_kernels import ", path.read_text(), re.MULTILINE)
