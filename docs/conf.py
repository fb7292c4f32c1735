"""Settings of Sphinx: `make docs`."""

from __future__ import annotations

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
