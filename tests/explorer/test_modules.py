"""The modules of the explorer find each other, and none is left over."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2] / "service" / "explorer" / "js"
MODULES = sorted(ROOT.rglob("*.js"))
IMPORT = re.compile(r'^import \{([^}]*)\} from "([^"]+)";$', re.MULTILINE)


def name_of(path):
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("module", MODULES, ids=name_of)
def test_what_a_module_imports_is_exported(module):
    text = module.read_text()
    assert len(IMPORT.findall(text)) == text.count("\nimport ")
    for names, path in IMPORT.findall(text):
        exported = (module.parent / path).read_text()
        for name in map(str.strip, names.split(",")):
            ours = rf"^export (async )?(function\*?|class|const|let) {name}\b"
            # A module of others is minified: all that it exports stands in one list, under other names.
            theirs = rf"\bexport\{{([^}}]*,)?\w+ as {name}[,}}]"
            assert re.search(f"{ours}|{theirs}", exported, re.MULTILINE)


def test_every_module_is_imported_by_another():
    imported = {(path.parent / other).resolve() for path in MODULES for _, other in IMPORT.findall(path.read_text())}
    assert set(MODULES) - imported == {ROOT / "main.js"}
