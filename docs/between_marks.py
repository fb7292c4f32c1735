"""Pages with a part that a script writes: the part stands between two marks, all else stays."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

#: A page names its source and script in the first mark: `<!-- from the registry: docs/collect_checks.py -->`.
BEGIN, CLOSE, END = "<!-- from the ", " -->\n", "<!-- end -->"


def filled(text: str, content: str) -> str:
    """Return a page with ``content`` between its marks.

    >>> filled("a\\n<!-- from the moon: x.py -->\\nold\\n<!-- end -->\\nb", "new")
    'a\\n<!-- from the moon: x.py -->\\nnew\\n<!-- end -->\\nb'
    """
    before, begin, rest = text.partition(BEGIN)
    source, close, old = rest.partition(CLOSE)
    _, end, after = old.partition(END)
    if not (begin and close and end):
        raise SystemExit(f"there are no two marks in the page that begins {text[:40]!r}")
    return f"{before}{begin}{source}{close}{content}\n{end}{after}"


def write(pages: Mapping[Path, str]) -> int:
    """Write what stands between the marks of each page anew; return the exit code of the script."""
    for path, content in pages.items():
        text = path.read_text(encoding="utf-8")
        path.write_text(filled(text, content), encoding="utf-8", newline="\n")
    return 0
