"""The blocks of code of the pages, and which of them a page itself says are not run."""

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
RUN = ("python", "sh")
NOT_RUN = "not run by the tests"


class Block(NamedTuple):
    """A block of code, the number of its first fence, and the paragraph before it."""

    file: str
    line: int
    language: str
    text: str
    before: str

    @property
    def exempt(self):
        """Whether the page says, right before the block, that the block is not run."""
        return NOT_RUN in self.before


def blocks_of(page):
    """Blocks of a page in order; a directive of the site is none."""
    text = page.read_text()
    found, last = [], 0
    for match in re.finditer(r"^```([^\n`]*)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE):
        paragraphs = text[last : match.start()].strip().split("\n\n")
        line = text.count("\n", 0, match.start()) + 1
        if not match[1].startswith("{"):
            found.append(Block(str(page.relative_to(ROOT)), line, match[1], match[2], paragraphs[-1]))
        last = match.end()
    return found
