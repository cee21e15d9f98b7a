"""A result as an RO-Crate 1.1: what its files are, how they were made, and what to cite."""

import json
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any, NamedTuple

from worker.stores.provenance import REFERENCES

METADATA = "ro-crate-metadata.json"
"""Name of the file that makes a folder an RO-Crate."""
_SPECIFICATION = "https://w3id.org/ro/crate/1.1"
_SPDX = "https://spdx.org/licenses/"
_PROGRAM = "#gear-rattle"


class CrateFile(NamedTuple):
    """A file of a crate: its bytes, its media type, and what it is."""

    content: bytes
    media_type: str
    name: str


def crate_metadata(
    attributes: Mapping[str, Any], files: Mapping[str, CrateFile], creator: str | None, license_name: str
) -> bytes:
    """The crate's own file: JSON-LD that describes all others.

    Parameters
    ----------
    attributes : mapping
        Attributes of the store.
    files : mapping of str to CrateFile
        Files of the crate by path.
    creator : str, optional
        Who made the result; by default nobody is named.
    license_name : str
        SPDX name of the licence of the result.

    Returns
    -------
    bytes
        Dates are those of the store, so the same store gives the same bytes.
    """
    license_id = _SPDX + license_name
    parts = [{"@id": path} for path in files]
    graph: list[dict[str, Any]] = [
        {
            "@id": METADATA, "@type": "CreativeWork", "about": {"@id": "./"},
            "conformsTo": {"@id": _SPECIFICATION},
        },
        {
            "@id": "./", "@type": "Dataset", "name": attributes["title"],
            "description": f"{attributes['title']}: request {attributes['request_sha256']}",
            "identifier": attributes["request_sha256"], "datePublished": attributes["finished"],
            "license": {"@id": license_id}, "hasPart": parts, "mentions": {"@id": "#run"},
            "citation": {"@id": _doi()},
        },
        {"@id": license_id, "@type": "CreativeWork", "name": license_name, "description": f"Licence {license_name}"},
        {"@id": _doi(), "@type": "ScholarlyArticle", "name": REFERENCES},
        {
            "@id": _PROGRAM, "@type": "SoftwareApplication", "name": "gear-rattle",
            "softwareVersion": _version_of(attributes), "description": "Basins of attraction of a rattling gear pair",
        },
        {
            "@id": "#run", "@type": "CreateAction", "name": attributes.get("history", "computation"),
            "instrument": {"@id": _PROGRAM}, "object": {"@id": "request.json"},
            "result": [part for part in parts if part["@id"] not in ("request.json", "versions.json")],
            "startTime": attributes["started"], "endTime": attributes["finished"],
        },
    ]  # fmt: skip
    graph += [
        {
            "@id": path, "@type": "File", "name": file.name, "encodingFormat": file.media_type,
            "contentSize": str(len(file.content)),
        }
        for path, file in files.items()
    ]  # fmt: skip
    if creator is not None:
        graph[1]["author"] = {"@id": "#creator"}
        graph.append({"@id": "#creator", "@type": "Person", "name": creator})
    document = {"@context": f"{_SPECIFICATION}/context", "@graph": graph}
    return json.dumps(document, indent=1, ensure_ascii=False).encode()


def _doi() -> str:
    return "https://doi.org/" + REFERENCES.rpartition("doi:")[2]


def _version_of(attributes: Mapping[str, Any]) -> str:
    """Version that computed the result; older stores say it only among all versions."""
    versions = attributes.get("versions", {})
    versions = json.loads(versions) if isinstance(versions, str) else versions
    return str(versions.get("gear-rattle", version("gear-rattle")))
