"""The page that shows the API: Swagger UI, from files of this package, so that it works without internet."""

from pathlib import Path

from fastapi import APIRouter
from fastapi.responses import FileResponse
from starlette.staticfiles import StaticFiles

_FILES = Path(__file__).parents[1] / "api_page"

router = APIRouter(include_in_schema=False)
files = StaticFiles(directory=_FILES)


@router.get("/docs")
def get_api_page() -> FileResponse:
    """Page of the API. Its addresses are relative to `/docs`, as behind a proxy with a prefix."""
    return FileResponse(_FILES / "index.html", headers={"cache-control": "no-cache"})
