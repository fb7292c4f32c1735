"""Settings of Sphinx: `make docs`."""

from __future__ import annotations

from sphinx.application import Sphinx

import graben

project = "graben"
author = "the graben maintainers"
copyright = "2026, the graben maintainers"
version = release = graben.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
# These are parts of other pages.
exclude_patterns = ["scores.md", "runs.md", "licences-table.md"]

html_theme = "furo"
html_title = f"graben {release}"

autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False


def _plain_bars(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Keep the bars of |x| in docstrings from being read as substitutions."""
    lines[:] = [line.replace("|", "\\|") for line in lines]


def setup(app: Sphinx) -> None:
    """Connect what this project adds."""
    app.connect("autodoc-process-docstring", _plain_bars)
