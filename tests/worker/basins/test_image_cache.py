"""Images stay with the process that has mapped a tile, once, and not more than it can spare."""

import numpy as np
import pytest

from rattle_kernels import CellImages
from worker.basins import image_cache


@pytest.fixture(autouse=True)
def nothing_kept():
    image_cache._cache.clear()


def _images(cells):
    return CellImages(np.zeros(cells, np.int64), np.zeros(cells), np.zeros(cells), 0)


def test_images_are_taken_once():
    images = _images(10)
    image_cache.keep("here", "digest", 3, images)
    assert image_cache.take("here", "digest", 2) is None
    assert image_cache.take("there", "digest", 3) is None
    assert image_cache.take("here", "other", 3) is None
    assert image_cache.take("here", "digest", 3) is images
    assert image_cache.take("here", "digest", 3) is None


def test_later_images_replace_the_oldest_beyond_32_megabytes():
    half = 16 * 2**20 // 24
    for number in range(3):
        image_cache.keep("here", "digest", number, _images(half))
    assert [image_cache.take("here", "digest", number) is None for number in range(3)] == [True, False, False]
    image_cache.keep("here", "digest", 0, _images(3 * half))
    assert image_cache.take("here", "digest", 0) is None
