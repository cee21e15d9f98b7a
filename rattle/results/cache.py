"""Results that are kept: each request has one store, named by its digest, so the same call again returns at once."""

import os
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

import platformdirs
from rich.filesize import decimal

if TYPE_CHECKING:
    from worker.jobs.job import Job


class ResultCache:
    """The folder of kept results: ``RATTLE_CACHE``, or the user's cache folder.

    Examples
    --------
    >>> import rattle
    >>> basin = rattle.basin(cells=20, progress=False)
    >>> len(rattle.cache.stores()) >= 1 and rattle.cache.size > 0
    True
    """

    @property
    def folder(self) -> Path:
        """Where results lie."""
        named = os.environ.get("RATTLE_CACHE")
        return Path(named) if named else platformdirs.user_cache_path("gear-rattle") / "results"

    @property
    def beside(self) -> Path:
        """Folder of what packages beside keep."""
        return self.folder / "beside"

    def location_of(self, job: "Job") -> str:
        """Store of a job, whether it is there or not."""
        return str(self.folder / f"{job.kind}-{job.digest[:32]}.zarr")

    def stores(self) -> list[Path]:
        """Stores that are there, complete or not."""
        return sorted(self.folder.glob("*.zarr"))

    @property
    def size(self) -> int:
        """Bytes that all of it takes."""
        kept = (*self.stores(), self.beside)
        return sum(file.stat().st_size for folder in kept for file in folder.rglob("*") if file.is_file())

    def clear(self) -> None:
        """Remove all of it. Datasets of stores that are still open can no longer be read."""
        for store in self.stores():
            shutil.rmtree(store)
        shutil.rmtree(self.beside, ignore_errors=True)

    def __repr__(self) -> str:
        return f"<{len(self.stores())} results, {decimal(self.size)}, in {self.folder}>"


cache = ResultCache()
"""The results that are kept: ``rattle.cache`` says how much there is, ``rattle.cache.clear()`` removes it."""
