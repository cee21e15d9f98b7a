"""What tests of proofs share with those of the worker."""

from tests.worker.conftest import store  # noqa: F401 - a fixture
