"""Images of the tiles that this process has mapped last, so that it need not read them back to label them.

Of n workers each labels about one in n of the tiles that it has mapped. Threads of one process read none back.
"""

import threading
from contextlib import suppress

from cachetools import FIFOCache

from rattle_kernels import CellImages

_MOST_BYTES = 32 * 2**20
_kept: FIFOCache[tuple[str, str, int], CellImages] = FIFOCache(
    _MOST_BYTES, getsizeof=lambda images: sum(each.nbytes for each in images[:3])
)
_lock = threading.Lock()


def keep(location: str, digest: str, number: int, images: CellImages) -> None:
    """Keep the images of a tile until they are taken, or until later ones need their 32 MB."""
    with _lock, suppress(ValueError):  # too large to be kept
        _kept[location, digest, number] = images


def take(location: str, digest: str, number: int) -> CellImages | None:
    """Images of a tile, once; None if they are not kept."""
    with _lock:
        return _kept.pop((location, digest, number), None)
