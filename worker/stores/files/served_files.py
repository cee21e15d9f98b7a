"""Files of a store that a service hands out."""

from typing import Any

from zarr.storage import FsspecStore

from worker.stores.files.checked_chunks import ChecksChunks


class _ServedFiles(ChecksChunks, FsspecStore):
    """Zarr's store at an address."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.name = str(self.path)


def files_at(address: str, storage_options: dict[str, Any] | None = None) -> Any:
    """Zarr store at an address, to read.

    Parameters
    ----------
    address : str
    storage_options : dict, optional
        ``headers`` of its requests.
    """
    return _ServedFiles.from_url(address, storage_options=storage_options, read_only=True)
