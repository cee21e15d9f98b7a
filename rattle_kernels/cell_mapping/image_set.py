"""The image set: the distinct images of all cells, one bit per cell.

The set is closed under the map, so it holds every cycle, and Hsu's algorithm needs nothing else. One bit per cell takes
12 MB for 1e8 cells, whatever the map. Marking an image and finding its place among the members take one look-up each;
sorted cell numbers would need a search. A tile reports only the words in which it set a bit.
"""

from typing import NamedTuple

import numpy as np

from rattle_kernels.numerics.jit import inlined, kernel

_WORD = 64


class ImageSet(NamedTuple):
    """Members of a set of cells, and the number of members before each word.

    ``words`` (uint64) holds 64 cells per word: bit ``cell % 64`` of word ``cell // 64`` is set if the cell is a member.
    ``before`` (int64, one entry more than words) counts the members below each word; its last entry counts all.
    """

    words: np.ndarray
    before: np.ndarray

    @property
    def size(self) -> int:
        """Number of members."""
        return int(self.before[-1])


class MarkedWords(NamedTuple):
    """Part of a set, as tiles report it: the words with a bit set (uint64) and their numbers (int64, ascending)."""

    number: np.ndarray
    word: np.ndarray


@kernel
def _mark(image_cell, words):
    for i in range(image_cell.size):
        cell = image_cell[i]
        if cell >= 0:
            words[cell >> 6] |= np.uint64(1) << np.uint64(cell & 63)


@kernel
def _list_members(words, cells):
    found = 0
    for i in range(words.size):
        word = words[i]
        while word != 0:
            bit = word & -word
            word ^= bit
            cells[found] = i * 64 + bits_below(bit)
            found += 1


@inlined
def place_of(image_set, cell):
    """Place of a cell among the members, in ascending order; -1 if it is not a member."""
    words, before = image_set
    number = cell >> 6
    if number >= words.size:
        return -1
    bit = np.uint64(1) << np.uint64(cell & 63)
    if words[number] & bit == 0:
        return -1
    return before[number] + _count_bits(words[number] & (bit - np.uint64(1)))


@inlined
def bits_below(bit):
    """Number of the only bit that is set in a word."""
    return _count_bits(bit - np.uint64(1))


@inlined
def _count_bits(word):
    # LLVM recognises this bitwise sum and compiles it to one instruction.
    word = word - ((word >> np.uint64(1)) & np.uint64(0x5555555555555555))
    word = (word & np.uint64(0x3333333333333333)) + ((word >> np.uint64(2)) & np.uint64(0x3333333333333333))
    word = (word + (word >> np.uint64(4))) & np.uint64(0x0F0F0F0F0F0F0F0F)
    return np.int64((word * np.uint64(0x0101010101010101)) >> np.uint64(56))


def mark_images(cells: int, image_cell: np.ndarray) -> MarkedWords:
    """Set of the distinct images in an array.

    Parameters
    ----------
    cells : int
        Number of cells of the whole grid.
    image_cell : ndarray of int64
        Cell numbers below `cells`; negative (reserved) images are skipped.

    Returns
    -------
    MarkedWords
    """
    words = np.zeros(-(-cells // _WORD), np.uint64)
    _mark(image_cell.ravel(), words)
    number = np.flatnonzero(words)
    return MarkedWords(number, words[number])


def unite(cells: int, parts: list[MarkedWords]) -> ImageSet:
    """Union of the images reported by all tiles.

    Parameters
    ----------
    cells : int
        Number of cells of the whole grid.
    parts : list of MarkedWords

    Returns
    -------
    ImageSet
    """
    words = np.zeros(-(-cells // _WORD), np.uint64)
    for part in parts:
        words[part.number] |= part.word
    return with_counts(words)


def with_counts(words: np.ndarray) -> ImageSet:
    """Image set with these words."""
    before = np.zeros(words.size + 1, np.int64)
    np.cumsum(np.bitwise_count(words), out=before[1:])
    return ImageSet(words, before)


@kernel
def _place_images(image_set, first_row, first_column, time_cells, image_cell, place):
    rows, columns = image_cell.shape
    for i in range(rows):
        for j in range(columns):
            at = place_of(image_set, (first_row + i) * time_cells + first_column + j)
            if at < 0:
                continue
            image = image_cell[i, j]
            place[at] = image if image < 0 else place_of(image_set, image)
            if image >= 0 and place[at] < 0:
                return image
    return -1


@kernel
def _has_members(words, rows, columns, time_cells):
    for row in range(rows[0], rows[1]):
        first, last = row * time_cells + columns[0], row * time_cells + columns[1] - 1
        for number in range(first >> 6, (last >> 6) + 1):
            word = words[number]
            if number == first >> 6:
                word = (word >> np.uint64(first & 63)) << np.uint64(first & 63)
            if number == last >> 6:
                word = word & (~np.uint64(0) >> np.uint64(63 - (last & 63)))
            if word != 0:
                return True
    return False


def has_members(image_set: ImageSet, rows: tuple[int, int], columns: tuple[int, int], time_cells: int) -> bool:
    """Whether any cell of a rectangle of the grid is a member.

    Parameters
    ----------
    image_set : ImageSet
    rows, columns : (int, int)
        Start and stop of the rectangle along velocity and along time.
    time_cells : int
        Cells of the whole grid along time.

    Returns
    -------
    bool
    """
    return bool(_has_members(image_set.words, rows, columns, time_cells))


def place_images(
    image_set: ImageSet, first: tuple[int, int], time_cells: int, image_cell: np.ndarray, place: np.ndarray
) -> None:
    """For the members in a rectangle, find the places of their images among all members.

    Parameters
    ----------
    image_set : ImageSet
        Fewer than 2e9 members.
    first : (int, int)
        Row and column of the rectangle's first cell.
    time_cells : int
        Cells of the whole grid along time.
    image_cell : ndarray of int64, shape (rows, columns)
        Images of the rectangle.
    place : ndarray of int32, shape (image_set.size,)
        Written for the members in the rectangle: the place of the member's image, or its reserved (negative) image.

    Raises
    ------
    ValueError
        If an image is not a member: the set is not closed under the map.
    """
    missing = _place_images(image_set, *first, time_cells, image_cell, place)
    if missing >= 0:
        raise ValueError(f"the image set is not closed: image {missing} is no member of it")


def members_of(image_set: ImageSet) -> np.ndarray:
    """Cell numbers of all members.

    Parameters
    ----------
    image_set : ImageSet

    Returns
    -------
    ndarray of int64, ascending
    """
    cells = np.empty(image_set.size, np.int64)
    _list_members(image_set.words, cells)
    return cells
