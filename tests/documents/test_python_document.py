"""What docs/guide/python.md shows runs, block by block, in one session."""

import re
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

DOCUMENT = (Path(__file__).parents[2] / "docs" / "guide" / "python.md").read_text()


@pytest.mark.slow
def test_the_guides_python_runs(service, tmp_path, monkeypatch):
    """Its service is one that runs here, and what takes a service minutes is smaller."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RATTLE_CACHE", str(tmp_path / "kept"))
    small = 'rattle.BasinJob(grid={"time": {"cells": 20}, "velocity": {"cells": 20}})'
    others = {"http://127.0.0.1:8000": service.url, "cells=1000": "cells=40", "rattle.BasinJob()": small}
    blocks, names = re.findall(r"```python\n(.*?)```", DOCUMENT, re.DOTALL), {}
    assert len(blocks) == 7
    for block in blocks:
        if "large.zarr" in block:
            continue  # 1e10 cells: tests/worker/stores and tests/worker/results have some
        for shown, here in others.items():
            block = block.replace(shown, here)
        exec(compile(block, "python.md", "exec"), names)
    assert names["job"].state == "succeeded" and names["basin"].rattle.complete
    assert Path("basin.zip").read_bytes().startswith(b"PK")
    assert Path("mine.pdf").read_bytes().startswith(b"%PDF")
    assert [axes.get_legend() is not None for axes in names["figure"].axes] == [False, False, True]
    plt.close("all")
