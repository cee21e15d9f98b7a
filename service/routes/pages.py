"""The pages: the explorer and the description of the API, with the files that they load.

All come from this package, so both work without internet.
"""

from pathlib import Path

from fastapi import APIRouter
from fastapi.responses import FileResponse, JSONResponse
from starlette.staticfiles import StaticFiles

from worker.additions import additions
from worker.kinds import KINDS
from worker.stores.provenance import REFERENCES, source

_EXPLORER = Path(__file__).parents[1] / "explorer"
_API_PAGE = Path(__file__).parents[1] / "api_page"
# Browsers ask at each visit, so a new version is seen at once.
_ASKED_AGAIN = {"cache-control": "no-cache"}

router = APIRouter(include_in_schema=False)
explorer_files = StaticFiles(directory=_EXPLORER)
api_page_files = StaticFiles(directory=_API_PAGE)


@router.get("/")
def get_explorer() -> FileResponse:
    """Page of the explorer."""
    return FileResponse(_EXPLORER / "index.html", headers=_ASKED_AGAIN)


@router.get("/explorer/kinds.json")
def get_kinds() -> JSONResponse:
    """Kinds of jobs, as the explorer needs to know them: where their requests are sent, and what they are in words."""
    kinds = {name: {"path": f"/v1/{kind.path}", "title": kind.title} for name, kind in KINDS.items()}
    return JSONResponse(kinds, headers=_ASKED_AGAIN)


@router.get("/explorer/additions.json")
def get_additions() -> JSONResponse:
    """What packages add to basins, as the explorer draws it and says it."""
    return JSONResponse([addition.page() for addition in additions()], headers=_ASKED_AGAIN)


@router.get("/explorer/citation.json")
def get_citation() -> JSONResponse:
    """What a caption cites."""
    return JSONResponse({"program": source(), "paper": REFERENCES}, headers=_ASKED_AGAIN)


@router.get("/docs")
def get_api_page() -> FileResponse:
    """Page of the API (Swagger UI). Its addresses are relative to `/docs`, as behind a proxy with a prefix."""
    return FileResponse(_API_PAGE / "index.html", headers=_ASKED_AGAIN)
