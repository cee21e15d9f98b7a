"""Condense the JSON of a run of the benchmarks: figures into a smaller JSON, and the table of docs/performance.md.

``python -m benchmarks.table RUN.json`` is what `make bench` ends with.
"""

import json
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

_DOCS = Path(__file__).parents[1] / "docs"
_BEGIN, _END = "<!-- table of make bench: begin -->", "<!-- end -->"
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
        "processor": machine["cpu"]["brand_raw"],
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


def table(figures: dict[str, Any]) -> str:
    """Markdown: name, least seconds of a round, and the other figures in words."""
    rows = ["| benchmark | s | figures |", "|---|---|---|"]
    for name, values in sorted(figures.items()):
        others = [f"{key.replace('_', ' ')} {_number(value)}" for key, value in values.items() if key != "seconds"]
        rows.append(
            f"| {name.removeprefix('test_').replace('_', ' ')} | {values['seconds']:.3g} | {'; '.join(others)} |"
        )
    return "\n".join(rows)


def main() -> None:
    """Write docs/performance.json and the table in docs/performance.md."""
    condensed = condense(json.loads(Path(sys.argv[1]).read_text()))
    (_DOCS / "performance.json").write_text(json.dumps(condensed, indent=1) + "\n")
    page = _DOCS / "performance.md"
    before, rest = page.read_text().split(_BEGIN)
    _, after = rest.split(_END)
    page.write_text(f"{before}{_BEGIN}\n{table(condensed['figures'])}\n{_END}{after}")


if __name__ == "__main__":
    main()
