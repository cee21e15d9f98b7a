"""``python -m benchmarks.suite``."""

from benchmarks.suite.command import app

app(prog_name="python -m benchmarks.suite")
