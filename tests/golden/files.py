"""The golden files: read, and written with sorted keys, so that a change is a few lines of a diff."""

import json
from pathlib import Path

FOLDER = Path(__file__).parent
WIDTH = 120


def read(name):
    """What a golden file holds."""
    return json.loads((FOLDER / name).read_text())


def write(name, value):
    """Write a golden file anew."""
    (FOLDER / name).write_text(_pretty(value) + "\n")


def _pretty(value, indent=""):
    """JSON; what fits stands in one line."""
    short = json.dumps(value, sort_keys=True, ensure_ascii=False)
    if len(indent + short) <= WIDTH or not isinstance(value, dict | list):
        return short
    inner = indent + " "
    if isinstance(value, dict):
        lines = [f"{json.dumps(name)}: {_pretty(value[name], inner)}" for name in sorted(value)]
    else:
        lines = [_pretty(each, inner) for each in value]
    opening, closing = "{}" if isinstance(value, dict) else "[]"
    return f"{opening}\n{inner}" + f",\n{inner}".join(lines) + f"\n{indent}{closing}"


def named(cases):
    """Ids of cases for pytest."""
    return [case["name"] for case in cases]
