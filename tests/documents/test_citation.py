"""CITATION.cff is valid, and every reference is the one of docs/references.bib."""

import re
import subprocess
import sys
from pathlib import Path

import bibtexparser
import pytest
import yaml

ROOT = Path(__file__).parents[2]
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text())
PAGES = {path: path.read_text() for path in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]}


def in_one_line(text):
    return " ".join(text.replace("*", "").split())


def entries():
    library = bibtexparser.parse_file(str(ROOT / "docs" / "references.bib"))
    assert not library.failed_blocks
    return {
        entry.key: {name: in_one_line(field.value) for name, field in entry.fields_dict.items()}
        for entry in library.entries
    }


BIBLIOGRAPHY = entries()
PAGES_IN_A_LINE = in_one_line("\n".join(PAGES.values()))
DOCSTRINGS = in_one_line("\n".join(path.read_text() for path in sorted((ROOT / "rattle_kernels").rglob("*.py"))))


def test_the_citation_is_of_the_schema():
    command = ["check-jsonschema", "--builtin-schema", "vendor.citation-file-format", ROOT / "CITATION.cff"]
    done = subprocess.run([Path(sys.executable).parent / command[0], *command[1:]], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("reference", CITATION["references"], ids=lambda reference: reference["title"][:30])
def test_a_reference_of_the_citation_is_that_of_the_bibliography(reference):
    (entry,) = [each for each in BIBLIOGRAPHY.values() if each["title"] == reference["title"]]
    assert "note" not in entry
    names = [f"{person['family-names']}, {person['given-names']}" for person in reference["authors"]]
    assert entry["author"] == " and ".join(names)
    assert entry["year"] == str(reference["year"])
    if "journal" in reference:
        told = (reference["journal"], reference["volume"], reference["issue"], reference["doi"])
        assert tuple(map(str, told)) == tuple(entry[name] for name in ("journal", "volume", "number", "doi"))
        assert entry["pages"] == f"{reference['start']}--{reference['end']}"
    else:
        assert entry["publisher"] == reference["publisher"]["name"]


def citations_of(entry, text):
    """What follows the title wherever it is cited in full: to the year, and what stands behind it."""
    places = [after for after in text.split(entry["title"])[1:] if entry["year"] in after[:200]]
    return [re.match(rf".*?{entry['year']}\)?[^.]*", after).group() for after in places]


@pytest.mark.parametrize("key", BIBLIOGRAPHY)
def test_each_entry_is_cited_with_its_volume_and_its_doubts(key):
    entry = BIBLIOGRAPHY[key]
    found = citations_of(entry, PAGES_IN_A_LINE + DOCSTRINGS)
    assert found, "nothing cites it"
    for told in found:
        assert entry["volume"] in told and entry.get("pages", "").partition("--")[0] in told
    for told in citations_of(entry, PAGES_IN_A_LINE):
        assert ("(not verified)" in told) == (entry.get("note") == "not verified")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_each_doi_of_a_page_is_in_the_bibliography(page):
    text = PAGES[page]
    for entry in BIBLIOGRAPHY.values():
        text = text.replace(entry.get("doi", "\0"), "")
    assert not re.search(r"\b10\.\d{4,}/", text)
