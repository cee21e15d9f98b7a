"""Images of the tiles that this process has mapped last, so that it need not read them back to label them.

Of n workers each labels about one in n of the tiles that it has mapped. Threads of one process read none back.
"""

import threading
from collections import OrderedDict

from rattle_kernels import CellImages

_MOST_BYTES = 32 * 2**20
_kept: OrderedDict[tuple[str, str, int], CellImages] = OrderedDict()
_lock = threading.Lock()


def _bytes(images: CellImages) -> int:
    return images.image_cell.nbytes + images.landing_time.nbytes + images.landing_velocity.nbytes


def keep(location: str, digest: str, number: int, images: CellImages) -> None:
    """Keep the images of a tile until they are taken, or until later ones need their 32 MB."""
    with _lock:
        _kept[location, digest, number] = images
        while sum(map(_bytes, _kept.values())) > _MOST_BYTES:
            _kept.popitem(last=False)


def take(location: str, digest: str, number: int) -> CellImages | None:
    """Images of a tile, once; None if they are not kept."""
    with _lock:
        return _kept.pop((location, digest, number), None)
