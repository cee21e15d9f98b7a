"""A file in answer to a request that may ask for a part of it (RFC 9110, section 14)."""

import re

from fastapi import Response
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException

from worker.stores.object_storage import StoredFile

_BYTES = "application/octet-stream"


def answer_range(file: StoredFile, headers: Headers) -> Response:
    """Answer with a file, or with the part of it that ``Range`` asks for.

    Parameters
    ----------
    file : StoredFile
    headers : Headers
        Of the request. Several ranges at once are answered with the whole file, as is a range of a file that is not the
        one which ``If-Range`` names.

    Returns
    -------
    Response

    Raises
    ------
    HTTPException
        416, where the range begins behind the end.
    """
    own = {"accept-ranges": "bytes", "etag": f'"{file.tag}"'}
    asked = re.fullmatch(r"bytes=(\d*)-(\d*)", headers.get("range", "").replace(" ", ""))
    if not asked or not any(asked.groups()) or headers.get("if-range", own["etag"]) != own["etag"]:
        return Response(file.content, media_type=_BYTES, headers=own)
    size = len(file.content)
    first, last = (int(number) if number else None for number in asked.groups())
    if first is None:
        first, last = max(0, size - (last or 0)), None
    stop = size if last is None else min(size, last + 1)
    if first >= size or stop <= first:
        raise HTTPException(416, f"the file has {size} bytes", headers={"content-range": f"bytes */{size}"})
    own["content-range"] = f"bytes {first}-{stop - 1}/{size}"
    return Response(file.content[first:stop], 206, media_type=_BYTES, headers=own)
