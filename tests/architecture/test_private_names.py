"""What the project uses of other projects' insides: each with its reason, and a test that fails when it moves."""

import ast
import importlib
from pathlib import Path

import pytest
from distributed.worker_state_machine import WorkerState
from pydantic import BaseModel
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

ROOT = Path(__file__).parents[2]
PACKAGES = sorted({path.parent.name for path in ROOT.glob("*/__init__.py")} - {"tests", "benchmarks"})
# Their maintainers promise nothing for these.
INSIDES = "zarr.core", "numba.core"

REASONS = {
    "numba.core.event": "the one way to see that a kernel is compiled",
    "numba.core.config": "where the cache of machine code lies",
    "numba.core.dispatcher.Dispatcher": "the type of a kernel, for a check of kernels that are called",
    "numba.core.compiler.Compiler": "compiles functions with the preference for wide registers (decision 32)",
    "numba.core.compiler.CompilerBase": "type of the pipeline of decision 32",
    "numba.core.compiler.DefaultPassBuilder": "passes of the pipeline of decision 32",
    "numba.core.compiler_machinery.PassManager": "type of the pipeline of decision 32",
    "numba.core.compiler_machinery.register_pass": "registers the pass of decision 32",
    "numba.core.lowering.Lower": "writes the attribute of decision 32 on a function",
    "numba.core.typed_passes.BaseNativeLowering": "the pass of decision 32 is one",
    "numba.core.typed_passes.NativeLowering": "the pass that decision 32 replaces",
    "typer._click.exceptions.BadOptionUsage": "raised by Typer, exported nowhere: it names the option that is wrong",
    "zarr.core.array.AsyncArray": "metadata of an array are written anew from the layout alone (decision 40)",
    "zarr.core.group.GroupMetadata": "metadata of a group are read without opening its arrays (decision 40)",
    "zarr.core.metadata.v3.ArrayV3Metadata": "as above, of an array",
    "zarr.core.buffer.default_buffer_prototype": "needed to call the public `Store.get`, and exported nowhere",
    "zarr.core.sync.sync": "runs a coroutine in Zarr's own loop, in which its stores must be used",
}
"""Names of the insides of other projects, and why they are used."""


def imported(path):
    """Names that a file imports from insides of other projects."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names = [f"{node.module}.{each.name}" for each in node.names]
        elif isinstance(node, ast.Import):
            names = [each.name for each in node.names]
        else:
            continue
        for name in names:
            own = name.split(".")[0] in PACKAGES
            private = any(part.startswith("_") and not part.startswith("__") for part in name.split("."))
            if not own and (private or name.startswith(INSIDES)):
                yield name


def test_insides_that_are_imported_are_those_with_a_reason():
    files = [path for package in PACKAGES for path in (ROOT / package).rglob("*.py")]
    found = {name for path in files for name in imported(path)}
    assert {"numba.core.event", "zarr.core.sync.sync"} <= found
    assert found == set(REASONS)


@pytest.mark.parametrize("name", REASONS)
def test_insides_are_where_they_were(name):
    module, _, attribute = name.rpartition(".")
    assert hasattr(importlib.import_module(module), attribute)


def test_attributes_that_no_document_promises_are_there():
    class Model(BaseModel):
        value: int

    # Jobs are validated with a context, which `BaseModel.__init__` does not take.
    model = Model.__new__(Model)
    Model.__pydantic_validator__.validate_python({"value": 1}, self_instance=model, context=object())
    assert model.value == 1
    # A worker knows the tasks that are not cancelled, and those that it executes.
    state = WorkerState()
    assert state.tasks == {} and not state.executing
    # The parser of a connection tells of each piece.
    pieces = "on_url", "on_header", "on_body", "on_message_begin", "on_message_complete", "send_400_response"
    assert all(hasattr(HttpToolsProtocol, piece) for piece in (*pieces, "_start_asgi_task"))
