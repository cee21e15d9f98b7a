"""Images stay with the process that has mapped a tile, once, and not more than it can spare."""

import numpy as np
import pytest

from rattle_kernels import CellImages
from worker.basins.tiles import just_mapped


@pytest.fixture(autouse=True)
def nothing_kept(monkeypatch):
    monkeypatch.setattr(just_mapped, "_kept", type(just_mapped._kept)())


def _images(cells):
    return CellImages(np.zeros(cells, np.int64), np.zeros(cells), np.zeros(cells), 0)


def test_images_are_taken_once():
    images = _images(10)
    just_mapped.keep("here", "digest", 3, images)
    assert just_mapped.take("here", "digest", 2) is None
    assert just_mapped.take("there", "digest", 3) is None
    assert just_mapped.take("here", "other", 3) is None
    assert just_mapped.take("here", "digest", 3) is images
    assert just_mapped.take("here", "digest", 3) is None


def test_later_images_replace_the_oldest_beyond_32_megabytes():
    half = 16 * 2**20 // 24
    for number in range(3):
        just_mapped.keep("here", "digest", number, _images(half))
    assert [just_mapped.take("here", "digest", number) is None for number in range(3)] == [True, False, False]
    just_mapped.keep("here", "digest", 0, _images(3 * half))
    assert just_mapped.take("here", "digest", 0) is None
