"""Condense the JSON of a run of the benchmarks: docs/performance.json and the tables of docs/performance.md.

Both keep the last run of each processor.

``python -m benchmarks.table RUN.json`` is what `make bench` ends with, on the same machine.
"""

import json
import sys
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import Any

from benchmarks import processor

_DOCS = Path(__file__).parents[1] / "docs"
_BEGIN, _END = "<!-- tables of make bench: begin -->", "<!-- end -->"
_PACKAGES = ("numpy", "numba", "llvmlite", "dask", "distributed", "zarr")


def condense(run: dict[str, Any]) -> dict[str, Any]:
    """Machine, versions, and least time and extra figures of every benchmark."""
    machine = run["machine_info"]
    figures = {
        benchmark["name"]: {"seconds": benchmark["stats"]["min"]} | benchmark["extra_info"]
        for benchmark in run["benchmarks"]
    }
    return {
        "date": run["datetime"][:10],
        "processor": processor(),
        "cores": machine["cpu"]["count"],
        "python": machine["python_version"],
        "versions": {package: version(package) for package in _PACKAGES},
        "figures": figures,
    }


def _number(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.3g}"
    if isinstance(value, list):
        return ", ".join(_number(item) for item in value)
    if isinstance(value, dict):
        return ", ".join(f"{key} {_number(item)}" for key, item in value.items())
    return str(value)


def section(run: dict[str, Any]) -> str:
    """Heading of a run, and its table: name, least seconds of a round, and the other figures in words."""
    machine = f"{run['processor']}, {run['cores']} cores"
    versions = ", ".join(f"{package} {number}" for package, number in run["versions"].items())
    lines = [
        f"### {machine}",
        f"{run['date']}, Python {run['python']}, {versions}.",
        "| benchmark | s | figures |\n|---|---|---|\n" + "\n".join(_rows(run["figures"])),
    ]
    return "\n\n".join(lines)


def _rows(figures: dict[str, Any]) -> Iterator[str]:
    for name, values in sorted(figures.items()):
        others = [f"{key.replace('_', ' ')} {_number(value)}" for key, value in values.items() if key != "seconds"]
        yield f"| {name.removeprefix('test_').replace('_', ' ')} | {values['seconds']:.3g} | {'; '.join(others)} |"


def main() -> None:
    """Enter a run in docs/performance.json, and write the tables of all processors in docs/performance.md."""
    run = condense(json.loads(Path(sys.argv[1]).read_text()))
    kept = _DOCS / "performance.json"
    runs = json.loads(kept.read_text()) | {run["processor"]: run}
    kept.write_text(json.dumps(runs, indent=1) + "\n")
    page = _DOCS / "performance.md"
    before, rest = page.read_text().split(_BEGIN)
    _, after = rest.split(_END)
    tables = "\n\n".join(section(runs[name]) for name in sorted(runs))
    page.write_text(f"{before}{_BEGIN}\n\n{tables}\n\n{_END}{after}")


if __name__ == "__main__":
    main()
