"""The API is described as ever, but for words; routes, schemas and fields of responses may be added."""

from tests.golden import api_document, files

# Fields that responses have got since. A field of a request would have to be optional.
ADDED: dict[str, tuple[str, ...]] = {}


def _without_added(name, schema):
    added = ADDED.get(name, ())
    assert all(field in schema["properties"] for field in added)
    if not added:
        return schema
    properties = {field: each for field, each in schema["properties"].items() if field not in added}
    required = [field for field in schema["required"] if field not in added]
    return schema | {"properties": properties, "required": required}


def test_the_document_has_the_same_structure():
    here, golden = api_document.structure(), files.read("openapi.json")
    assert set(here) == set(golden)
    assert {path: here["paths"][path] for path in golden["paths"]} == golden["paths"]
    for kind, parts in golden["components"].items():
        assert {name: _without_added(name, here["components"][kind][name]) for name in parts} == parts
