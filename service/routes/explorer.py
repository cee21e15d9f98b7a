"""The explorer: its page, and the files that the page loads."""

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
