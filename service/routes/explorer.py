"""The explorer: its page, the page of the API, and the files that both load."""

from pathlib import Path

from fastapi import APIRouter
from fastapi.responses import FileResponse
from starlette.staticfiles import StaticFiles

_FILES = Path(__file__).parents[1] / "explorer"

router = APIRouter(include_in_schema=False)
files = StaticFiles(directory=_FILES)


@router.get("/")
def get_page() -> FileResponse:
    """Page of the explorer. Browsers revalidate it at each visit, so a new version is seen at once."""
    return FileResponse(_FILES / "index.html", headers={"cache-control": "no-cache"})


@router.get("/docs")
def get_reference() -> FileResponse:
    """Page of the API. Nothing of it comes from elsewhere, so it works without the internet."""
    return FileResponse(_FILES / "docs.html", headers={"cache-control": "no-cache"})
