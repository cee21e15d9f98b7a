"""The directives ``{rest-routes}`` and ``{rest-schemas}``: what docs/openapi.yaml says, as Markdown."""

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import yaml
from docutils.nodes import Node
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

_API = yaml.safe_load((Path(__file__).parents[1] / "openapi.yaml").read_text())

Schema = dict[str, Any]


class Routes(SphinxDirective):
    """Every route: what it does, takes and answers, in the document's order."""

    def run(self) -> list[Node]:
        """Write Markdown."""
        operations = [
            (f"{method.upper()} {path}", operation)
            for path, by_method in _API["paths"].items()
            for method, operation in by_method.items()
        ]
        return _parsed(self, (line for title, operation in operations for line in _route(title, operation)))


class Schemas(SphinxDirective):
    """Every body: its fields, in alphabetical order."""

    def run(self) -> list[Node]:
        """Write Markdown."""
        bodies = sorted(_API["components"]["schemas"].items())
        return _parsed(self, (line for name, schema in bodies for line in _body(name, schema)))


def _parsed(directive: SphinxDirective, lines: Iterable[str]) -> list[Node]:
    return directive.parse_text_to_nodes("\n".join(lines), allow_section_headings=True)


def _route(title: str, operation: Schema) -> Iterator[str]:
    yield from ("", f"## {title}", "", f"*{operation['summary']}.* {operation.get('description', '')}", "")
    for content in operation.get("requestBody", {}).get("content", {}).values():
        yield from (f"Body: {_kind(content['schema'])}.", "")
    if parameters := operation.get("parameters"):
        yield from ("| parameter | in | type | meaning |", "|---|---|---|---|")
        for each in parameters:
            meaning = _cell(each.get("description", each["schema"].get("description", "")) + _default(each["schema"]))
            yield f"| `{each['name']}` | {each['in']} | {_kind(each['schema'])} | {meaning} |"
        yield ""
    yield from ("| status | body | meaning |", "|---|---|---|")
    for status, answer in sorted(operation["responses"].items()):
        yield f"| {status} | {_kinds(answer.get('content', {}))} | {_cell(answer['description'])} |"


def _body(name: str, schema: Schema) -> Iterator[str]:
    yield from ("", f"({_target(name)})=", f"## {name}", "", schema.get("description", ""), "")
    if "properties" not in schema:
        yield f"{_kind(schema)}"
        return
    yield from ("| field | type | meaning |", "|---|---|---|")
    for field, of in schema["properties"].items():
        required = "**required** " if field in schema.get("required", ()) else ""
        yield f"| `{field}` | {_kind(of)} | {required}{_cell(of.get('description', '') + _default(of))} |"


def _kinds(contents: Schema) -> str:
    """What is answered: a body by its name, where it is JSON; anything else by its media type."""
    return ", ".join(
        _kind(content["schema"]) if "json" in media and content.get("schema") else f"`{media}`"
        for media, content in contents.items()
    )


def _kind(schema: Schema) -> str:
    """Kind of value in words; a body by its name, as a link to its fields."""
    if reference := schema.get("$ref"):
        name = reference.rpartition("/")[2]
        return f"[{name}](#{_target(name)})"
    for several in ("anyOf", "oneOf"):
        if several in schema:
            return " or ".join(_kind(each) for each in schema[several])
    if "const" in schema:
        return f"`{json.dumps(schema['const'])}`"
    if "enum" in schema:
        return ", ".join(f"`{json.dumps(value)}`" for value in schema["enum"])
    if schema.get("type") == "array":
        held = schema.get("prefixItems", [schema.get("items", {})])
        return "list of " + ", ".join(_kind(each) for each in held)
    return str(schema.get("type", "any")) + _bounds(schema)


def _bounds(schema: Schema) -> str:
    words = {
        "minimum": "≥ ", "exclusiveMinimum": "> ", "maximum": "≤ ", "exclusiveMaximum": "< ",
    }  # fmt: skip
    return "".join(f" {sign}{schema[bound]:g}" for bound, sign in words.items() if bound in schema)


def _default(schema: Schema) -> str:
    return f" (default `{json.dumps(schema['default'])}`)" if "default" in schema else ""


def _cell(text: str) -> str:
    return " ".join(text.replace("|", r"\|").split())


def _target(name: str) -> str:
    return f"body-{name.lower()}"


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.add_directive("rest-routes", Routes)
    app.add_directive("rest-schemas", Schemas)
    return {"parallel_read_safe": True}
