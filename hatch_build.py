"""The page of a package index: the README, whose links lead out of the package only where they lead somewhere.

An index knows no folders of the project. With RATTLE_REPOSITORY, the address of the repository on the web, relative
links and pictures become absolute and the page links documentation, source and changelog; without it they are taken
out, and links leave their text.
"""

import os
import re
from pathlib import Path

from hatchling.metadata.plugin.interface import MetadataHookInterface

PAPER = "https://doi.org/10.1142/S021812740902283X"
# A picture, or a link: what is in brackets, and the target.
_LINK = re.compile(r"(!?)\[([^\]]*)\]\((?!https?://|mailto:|#)([^)\s]+)\)")


def page(text: str, repository: str | None) -> str:
    """The README as an index shows it.

    Parameters
    ----------
    text : str
        Markdown.
    repository : str or None
        Address of the repository on the web, as in ``https://HOST/OWNER/NAME``.

    Returns
    -------
    str
    """

    def absolute(found: re.Match[str]) -> str:
        is_picture, words, target = bool(found[1]), found[2], found[3]
        if repository is None:
            return "" if is_picture else words
        return f"{found[1]}[{words}]({repository}/{'raw' if is_picture else 'blob'}/HEAD/{target})"

    return re.sub(r"\n{3,}", "\n\n", _LINK.sub(absolute, text))


def addresses(repository: str | None) -> dict[str, str]:
    """Links that an index shows beside the page."""
    if repository is None:
        return {"Paper": PAPER}
    return {
        "Documentation": f"{repository}/blob/HEAD/docs/README.md",
        "Source": repository,
        "Changelog": f"{repository}/blob/HEAD/CHANGELOG.md",
        "Paper": PAPER,
    }


class Page(MetadataHookInterface):
    """Gives the metadata their README and links."""

    def update(self, metadata: dict) -> None:
        """Add both."""
        repository = (os.environ.get("RATTLE_REPOSITORY") or "").rstrip("/") or None
        text = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        metadata["readme"] = {"content-type": "text/markdown", "text": page(text, repository)}
        metadata["urls"] = addresses(repository)
