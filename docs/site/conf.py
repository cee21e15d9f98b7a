"""The documentation site: README, docs/ and notebooks/ as they lie, with pages made from the code (`make docs`)."""

import sys
from importlib.metadata import version as version_of
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from numpydoc.xref import DEFAULT_LINKS  # noqa: E402
from public_names import class_names  # noqa: E402

project = "gear-rattle"
author = copyright = "The gear-rattle developers"
release = version = version_of(project)

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "chapters",
    "mathml",
    "public_names",
    "shell_commands",
    "rest_routes",
]
root_doc = "README"
include_patterns = ["*.md", "docs/**.md", "notebooks/*"]
exclude_patterns = [".*", "node_modules", "screenshots", "dist", "build", "demo", "tests", "service", "worker"]
highlight_language = "text"

# A reference that leads nowhere is a warning, and `make docs` makes warnings errors. Names of other projects are left
# out: their inventories are elsewhere, and the site is built without a network.
nitpicky = True
default_role = "py:obj"

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
nb_execution_mode = "off"
nb_merge_streams = True

autodoc_typehints = "none"
autodoc_member_order = "bysource"
autosummary_generate = False
# Types of parameters lead to classes of ours; words such as float stay words.
numpydoc_xref_param_type = True
numpydoc_xref_ignore = "all"
numpydoc_xref_aliases = {word: word for word in DEFAULT_LINKS} | class_names()
numpydoc_show_class_members = False
numpydoc_validation_checks = {"GL08", "SS01"}

html_math_renderer = "mathml"
html_context = {"default_mode": "auto"}
html_theme = "pydata_sphinx_theme"
html_title = "gear-rattle"
html_static_path = [str(HERE / "static")]
html_css_files = ["site.css"]
html_show_sourcelink = html_copy_source = False
# Pages that are alone in their chapter.
html_sidebars = {page: [] for page in ("docs/performance", "docs/benchmarks", "CHANGELOG", "CONTRIBUTING", "SECURITY")}
html_theme_options = {
    "header_links_before_dropdown": 7,
    "navbar_align": "left",
    "footer_start": ["copyright"],
    "footer_end": [],
    "show_toc_level": 2,
}
