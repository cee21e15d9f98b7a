"""What a user sees of a finished store: pictures from the store and from the dataset, tables of the shell, measures."""

import csv
import hashlib
import io
import math
from collections import Counter

import numpy as np
from PIL import Image

from tests.golden.adapter import drawn_by_shell, drawn_from_dataset, measured, tabled

MOST_COMMON = 8
ROWS = 12


def shown(folder):
    """All that is kept of what a store shows."""
    return {
        "drawn": {
            "by the shell": {options: picture(png) for options, png in drawn_by_shell(folder).items()},
            "from the dataset": {call: picture(png) for call, png in drawn_from_dataset(folder).items()},
        },
        "tables": {name: table(text) for name, text in tabled(folder).items()},
        "measured": {name: value(each) for name, each in measured(folder).items()},
    }


def picture(png):
    """Size of a picture, a hash of its pixels, and its commonest colours with their counts, which say what differs."""
    if isinstance(png, str):
        return png
    pixels = np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))
    colours = Counter(map(bytes, pixels.reshape(-1, 3)))
    return {
        "size": list(pixels.shape[1::-1]),
        "sha256": hashlib.sha256(pixels.tobytes()).hexdigest(),
        "colours": {colour.hex(): count for colour, count in colours.most_common(MOST_COMMON)},
    }


def table(text):
    """Columns, the number of rows, and some of them."""
    columns, *rows = csv.reader(io.StringIO(text))
    some = rows if len(rows) <= ROWS else rows[:: -(-len(rows) // ROWS)]
    return {"columns": columns, "length": len(rows), "some": [[_number(cell) for cell in row] for row in some]}


def _number(cell):
    try:
        return _finite(float(cell))
    except ValueError:
        return cell


def _finite(number):
    return number if math.isfinite(number) else str(number)


def value(found):
    """A value of the accessor as JSON: an array or a dataset by its shape and some of its numbers."""
    if hasattr(found, "data_vars"):
        return {"dims": {str(name): size for name, size in found.sizes.items()}} | {
            str(name): _array(each) for name, each in sorted({**found.coords, **found.data_vars}.items())
        }
    if hasattr(found, "values") and hasattr(found, "dims"):
        return _array(found)
    if isinstance(found, dict):
        return {str(name): value(each) for name, each in found.items()}
    if isinstance(found, list | tuple):
        return [value(each) for each in found]
    return _finite(found) if isinstance(found, float) else found


def _array(array):
    flat = np.asarray(array.values).ravel()
    some = flat if flat.size <= ROWS else flat[:: -(-flat.size // ROWS)]
    return {"dims": list(map(str, array.dims)), "shape": list(array.shape), "some": [_plain(each) for each in some]}


def _plain(each):
    if np.issubdtype(type(each), np.floating):
        return _finite(float(each))
    return each.item() if hasattr(each, "item") else str(each)
