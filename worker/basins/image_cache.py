"""Images of the tiles that this process has mapped last, so that it need not read them back to label them.

Of n workers each labels about one in n of the tiles that it has mapped. Threads of one process read none back.
"""

import contextlib
import threading

from cachetools import FIFOCache

from rattle_kernels import CellImages


def _bytes(images: CellImages) -> int:
    return images.image_cell.nbytes + images.landing_time.nbytes + images.landing_velocity.nbytes


_cache: FIFOCache[tuple[str, str, int], CellImages] = FIFOCache(32 * 2**20, getsizeof=_bytes)
_lock = threading.Lock()


def keep(location: str, digest: str, number: int, images: CellImages) -> None:
    """Keep the images of a tile until they are taken, or until later ones need their 32 MB."""
    with _lock, contextlib.suppress(ValueError):  # one that is larger by itself is not kept
        _cache[location, digest, number] = images


def take(location: str, digest: str, number: int) -> CellImages | None:
    """Images of a tile, once; None if they are not kept."""
    with _lock:
        return _cache.pop((location, digest, number), None)
