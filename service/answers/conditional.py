"""Conditional responses: each has an ETag, and is a 304 if the client already has the current version."""

import hashlib
from typing import Annotated, NamedTuple

from fastapi import Header, Response

IfNoneMatch = Annotated[
    str | None, Header(description="ETag of an earlier answer: where nothing has changed since, 304 says so")
]
NOT_MODIFIED: dict[int | str, dict[str, object]] = {304: {"description": "nothing has changed since"}}


class JsonAnswer(NamedTuple):
    """JSON body of a response, and its ETag."""

    body: str
    etag: str


def json_answer(body: str) -> JsonAnswer:
    """Response whose ETag depends only on its body."""
    return JsonAnswer(body, etag_of(body))


def etag_of(*parts: bytes | str) -> str:
    """ETag that depends on these parts and on nothing else."""
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        digest.update(len(data).to_bytes(8, "little") + data)
    return f'"{digest.hexdigest()[:32]}"'


def not_modified(etag: str, known: str | None) -> Response | None:
    """A 304 response if `known`, the request's If-None-Match, lists this ETag; otherwise None."""
    tags = [tag.strip().removeprefix("W/") for tag in (known or "").split(",")]
    return Response(status_code=304, headers={"etag": etag}) if etag in tags or "*" in tags else None


def json_or_not_modified(answer: JsonAnswer, known: str | None) -> Response:
    """Response with JSON, or a 304 if the client already has it."""
    body, etag = answer
    return not_modified(etag, known) or Response(body, media_type="application/json", headers={"etag": etag})
