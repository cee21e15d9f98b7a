"""The documentation site as `make docs` builds it."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def build(target, source=ROOT):
    """Build a source folder into ``target/site``."""
    options = ["--quiet", "--fail-on-warning", "--fresh-env", "--conf-dir", ROOT / "docs" / "site"]
    command = [sys.executable, "-m", "sphinx", *options, "--doctree-dir", target / "doctrees", source, target / "site"]
    return subprocess.run(command, cwd=source, capture_output=True, text=True, timeout=300)
