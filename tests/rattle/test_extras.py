"""The base install computes and draws. A missing part is named with the extra that brings it."""

import subprocess
import sys

import pytest

SERVICE = ("fastapi", "starlette", "uvicorn", "sqlalchemy", "alembic", "prometheus_client")
BASE_ONLY = (*SERVICE, "psycopg", "obstore")


def without(missing, *arguments):
    """A command where some packages cannot be imported."""
    code = f"import sys; sys.modules.update(dict.fromkeys({missing!r})); from rattle.cli import app; app()"
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True, timeout=110
    )


@pytest.mark.slow
def test_the_base_install_computes_draws_and_lists(tmp_path):
    store, picture = tmp_path / "basin.zarr", tmp_path / "basin.svg"
    done = without(BASE_ONLY, "basin", "--cells", 16, 16, "--iterations", 101, "--out", store)
    assert done.returncode == 0 and "P(1,1,0)" in done.stdout, done.stderr
    assert without(BASE_ONLY, "plot", store, "--out", picture).returncode == 0
    assert picture.read_bytes().startswith(b"<?xml")
    assert "permanent contact" in without(BASE_ONLY, "table", store).stdout


@pytest.mark.parametrize(
    ("missing", "arguments", "told"),
    [
        (SERVICE, ["serve"], "gear-rattle[service]"),
        (SERVICE, ["keys", "list"], "gear-rattle[service]"),
        (["obstore"], ["basin", "--out", "s3://bucket/basin"], "gear-rattle[s3]"),
    ],
)
def test_a_missing_part_is_named_with_its_extra(missing, arguments, told):
    done = without(missing, *arguments)
    assert done.returncode in (1, 2) and told in " ".join(done.stderr.split()), done.stderr
    assert "Traceback" not in done.stderr
