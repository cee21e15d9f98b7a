"""What tests of proofs share with those of the worker. All of them run apart from the fast tests."""

from pathlib import Path

import pytest

from tests.worker.conftest import store  # noqa: F401 - a fixture


def pytest_collection_modifyitems(items):
    """Mark the tests of this folder: the hook sees those of every other as well."""
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.proof)
