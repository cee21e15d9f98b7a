"""Files of a store over HTTP, whole or in part (RFC 9110, section 14). Only the requested bytes are read."""

import re

from fastapi import Response
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException

from worker.storage.location import read_file_of_store

_BYTES = "application/octet-stream"
_MOST_DIGITS = 18


def range_of_file(location: str, path: str, headers: Headers) -> Response | None:
    """Respond with a file of a store, or with the part of it that ``Range`` requests.

    Parameters
    ----------
    location : str
        Location of the store.
    path : str
        Path within the store.
    headers : Headers
        Headers of the request. The response is the whole file if several ranges are requested, or if ``If-Range``
        names another version of the file.

    Returns
    -------
    Response, optional
        None if the store has no such file.

    Raises
    ------
    HTTPException
        416 if the range begins after the end of the file.
    """

    def part(size: int, tag: str) -> tuple[int, int]:
        return _requested(headers, size, tag) or (0, size)

    file = read_file_of_store(location, path, part)
    if file is None:
        return None
    own = {"accept-ranges": "bytes", "etag": f'"{file.tag}"'}
    if _requested(headers, file.size, file.tag) is None:
        return Response(file.content, media_type=_BYTES, headers=own)
    own["content-range"] = f"bytes {file.start}-{file.start + len(file.content) - 1}/{file.size}"
    return Response(file.content, 206, media_type=_BYTES, headers=own)


def _requested(headers: Headers, size: int, tag: str) -> tuple[int, int] | None:
    """First byte of the requested range and the one after its last; None for the whole file."""
    match = re.fullmatch(r"bytes=(\d*)-(\d*)", headers.get("range", "").replace(" ", ""))
    if not match or not any(match.groups()) or headers.get("if-range", f'"{tag}"') != f'"{tag}"':
        return None
    first, last = (_number(digits) if digits else None for digits in match.groups())
    if first is None:
        first, last = max(0, size - (last or 0)), None
    stop = size if last is None else min(size, last + 1)
    if first >= size or stop <= first:
        raise HTTPException(416, f"the file has {size} bytes", headers={"content-range": f"bytes */{size}"})
    return first, stop


def _number(digits: str) -> int:
    """Number that digits write, or one beyond the end of any file where they are too many to read."""
    return int(digits) if len(digits) <= _MOST_DIGITS else 1 << 62
