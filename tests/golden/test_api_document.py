"""The API is described as ever, but for words."""

from tests.golden import api_document, files


def test_the_document_has_the_same_structure():
    assert api_document.structure() == files.read("openapi.json")
