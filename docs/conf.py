"""Settings of Sphinx: `make docs`."""

from __future__ import annotations

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

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

# Formulas are part of the pages (MathML), so that these need no network.
html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"graben {release}"

autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False


def _plain_bars(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Keep the bars of |x| in docstrings from being read as substitutions."""
    lines[:] = [line.replace("|", "\\|") for line in lines]


def _inline_formula(writer: HTML5Translator, node: nodes.math) -> None:
    """Write a formula within a line."""
    writer.body.append(tex2mathml(node.astext()))
    raise nodes.SkipNode


def _formula(writer: HTML5Translator, node: nodes.math_block) -> None:
    """Write a formula on a line of its own."""
    writer.body.append(tex2mathml(node.astext(), as_block=True))
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Connect what this project adds."""
    app.add_html_math_renderer("mathml", (_inline_formula, None), (_formula, None))
    app.connect("autodoc-process-docstring", _plain_bars)
