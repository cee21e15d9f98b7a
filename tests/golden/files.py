"""The golden files: read, and written with sorted keys, so that a change is a few lines of a diff."""

import json
from pathlib import Path

FOLDER = Path(__file__).parent


def read(name):
    """What a golden file holds."""
    return json.loads((FOLDER / name).read_text())


def write(name, value):
    """Write a golden file anew."""
    (FOLDER / name).write_text(json.dumps(value, indent=1, sort_keys=True, ensure_ascii=False) + "\n")


def named(cases):
    """Ids of cases for pytest."""
    return [case["name"] for case in cases]
