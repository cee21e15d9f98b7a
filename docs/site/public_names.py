"""The directive ``{names}``: documents names of a public module, and the check that every name is documented.

The pages of docs/api list the names in groups; what is said of each comes from its docstring.
"""

import ast
import inspect
from enum import Enum
from importlib import import_module
from typing import Any

from docutils.nodes import Element, Node
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.pycode import ModuleAnalyzer
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

_LOGGER = logging.getLogger(__name__)
_MODULES = ("rattle", "rattle.pictures", "rattle_kernels", "rattle_proof")


class Names(SphinxDirective):
    """Names of a module, one a line: a table of what they are, then each with its docstring."""

    required_arguments = 1
    has_content = True

    def run(self) -> list[Node]:
        """Leave the rest to autosummary and autodoc."""
        module, names = self.arguments[0], " ".join(self.content).split()
        # Of a constant autosummary would show what its type is.
        callables = [name for name in names if callable(getattr(import_module(module), name))]
        table = [
            f".. currentmodule:: {module}",
            "",
            ".. autosummary::",
            "   :nosignatures:",
            "",
            *(f"   {name}" for name in callables),
            "",
        ]
        entries = [line for name in names for line in _entry(module, name)]
        return self.parse_text_to_nodes("\n".join(["```{eval-rst}", *table, *entries, "```"]))


def class_names() -> dict[str, str]:
    """Public classes by their short names."""
    faces = [import_module(module) for module in _MODULES]
    names = ((face, name) for face in faces for name in face.__all__ if inspect.isclass(getattr(face, name)))
    return {name: f"{face.__name__}.{name}" for face, name in names}


def _entry(module: str, name: str) -> list[str]:
    found = getattr(import_module(module), name)
    if not (inspect.isclass(found) or callable(found)):
        return _constant(module, name, found)
    if not inspect.isclass(found):
        return [f".. autofunction:: {module}.{name}", ""]
    kind = "autoexception" if issubclass(found, BaseException) else "autoclass"
    # What an enumeration's members stand for is said in the docstring of the class.
    every = ["   :undoc-members:"] * issubclass(found, Enum)
    return [f".. {kind}:: {module}.{name}", "   :members:", *every, ""]


def _constant(module: str, name: str, value: Any) -> list[str]:
    """A constant of the current module.

    Its docstring follows it in the module that defines it, where autodoc does not look.
    """
    written = ModuleAnalyzer.for_module(_home_of(module, name)).find_attr_docs().get(("", name), [])
    if not any(written):
        _LOGGER.warning("%s.%s has no docstring", module, name)
    shown = [f"   :value: {value!r}"] * isinstance(value, int)
    return [f".. py:data:: {name}", *shown, "", *(f"   {line}" for line in written), ""]


def _home_of(module: str, name: str) -> str:
    face = import_module(module)
    imports = ast.walk(ast.parse(inspect.getsource(face)))
    return next(
        node.module
        for node in imports
        if isinstance(node, ast.ImportFrom) and node.module and name in (alias.name for alias in node.names)
    )


def _is_left_out(app: Sphinx, what: str, name: str, member: Any, skip: bool, options: Any) -> bool | None:
    """Fields of named tuples have no docstring of their own, the class says what they are; and pydantic's settings."""
    unsaid = (inspect.getdoc(member) or "").startswith("Alias for field number")
    return True if unsaid or name == "model_config" else None


def _find_in_public_modules(app: Sphinx, env: BuildEnvironment, node: Any, shown: Element) -> Element | None:
    """A name without its module, or of a public module that has it from another one."""
    domain = env.domains.python_domain
    name = node["reftarget"].removeprefix("rattle.") if node.get("refdomain") == "py" else ""
    for module in _MODULES:
        if f"{module}.{name}" in domain.objects:
            return domain.resolve_xref(env, node["refdoc"], app.builder, "obj", f"{module}.{name}", node, shown)
    return None


def _check_all_are_there(app: Sphinx, env: BuildEnvironment) -> None:
    for module in _MODULES:
        for name in import_module(module).__all__:
            if not _is_documented(env, getattr(import_module(module), name), name):
                _LOGGER.warning("no page of docs/api documents %s.%s", module, name)


def _is_documented(env: BuildEnvironment, value: Any, name: str) -> bool:
    """Whether it has an entry, if under the same name of another public module."""
    objects = env.domains.python_domain.objects
    homes = [module for module in _MODULES if f"{module}.{name}" in objects]
    return any(getattr(import_module(module), name, None) is value for module in homes)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.add_directive("names", Names)
    app.connect("autodoc-skip-member", _is_left_out)
    app.connect("missing-reference", _find_in_public_modules)
    app.connect("env-check-consistency", _check_all_are_there)
    return {"parallel_read_safe": True}
