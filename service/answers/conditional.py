"""Answers that a client need not be sent again: an ETag, and 304 where the client has it already."""

import hashlib
from typing import Annotated, NamedTuple

from fastapi import Header, Response
from pydantic import BaseModel

IfNoneMatch = Annotated[
    str | None, Header(description="ETag of an earlier answer: where nothing has changed since, 304 says so")
]
NOT_MODIFIED: dict[int | str, dict[str, object]] = {304: {"description": "nothing has changed since"}}


class Told(NamedTuple):
    """An answer's JSON, and its ETag."""

    body: str
    etag: str


def told(body: str) -> Told:
    """Answer of which the ETag is made of nothing else."""
    return Told(body, etag_of(body))


def etag_of(*parts: bytes | str) -> str:
    """ETag of what is made of these parts and of nothing else."""
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        digest.update(len(data).to_bytes(8, "little") + data)
    return f'"{digest.hexdigest()[:32]}"'


def not_modified(etag: str, known: str | None) -> Response | None:
    """Answer 304 where the client knows this ETag."""
    tags = [tag.strip().removeprefix("W/") for tag in (known or "").split(",")]
    return Response(status_code=304, headers={"etag": etag}) if etag in tags or "*" in tags else None


def view_or_not_modified(view: BaseModel, known: str | None) -> Response:
    """Answer with a view, or 304 where the client has just that."""
    return json_or_not_modified(told(view.model_dump_json()), known)


def json_or_not_modified(answer: Told, known: str | None) -> Response:
    """Answer with JSON, or 304 where the client has what this ETag is of."""
    body, etag = answer
    return not_modified(etag, known) or Response(body, media_type="application/json", headers={"etag": etag})
