"""The API is described as ever, but for words; routes and schemas may be added."""

from tests.golden import api_document, files


def test_the_document_has_the_same_structure():
    here, golden = api_document.structure(), files.read("openapi.json")
    assert set(here) == set(golden)
    assert {path: here["paths"][path] for path in golden["paths"]} == golden["paths"]
    for kind, parts in golden["components"].items():
        assert {name: here["components"][kind][name] for name in parts} == parts
