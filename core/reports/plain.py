"""Plain text for a terminal or a mail: lines that are not too long, and not too many of them."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Iterable, Sequence

#: Columns of a line, and lines of a summary, that a terminal and a mail show as they are.
LINE, PAGE = 80, 25
#: Stands for a width at which no line is broken, so that a search finds whole sentences.
UNBROKEN = 100_000
#: How many things of a kind a summary lists: the most of these with which it fits a page.
_MOST = (20, 12, 8, 5, 3, 2, 1, 0)
#: So many names are listed in a line.
_MOST_NAMES = 6


def folded(text: str, indent: str = "", width: int = LINE) -> list[str]:
    """Return text in lines of a width, those after the first indented by two more.

    >>> folded("To do: extend F1 to F2.", "  ", 16)
    ['  To do: extend', '    F1 to F2.']
    """
    return textwrap.wrap(
        text.lstrip(),
        max(width, len(indent) + 10),
        initial_indent=indent,
        subsequent_indent=indent + "  ",
        break_on_hyphens=False,
    )


def fitted(make: Callable[[int], Sequence[str]]) -> list[str]:
    """Return the lines of ``make(most)`` for the largest ``most`` with which they fit a page, or for 0."""
    lines: Sequence[str] = ()
    for most in _MOST:
        lines = make(most)
        if len(lines) <= PAGE:
            break
    return list(lines)


def named(names: Sequence[str]) -> str:
    """Return names in one line, not without end."""
    left = len(names) - _MOST_NAMES
    return ", ".join(names[:_MOST_NAMES]) + (f" and {left} more" if left > 0 else "")


def more(count: int, most: int, indent: str = "", of: Sequence[str] = (), width: int = LINE) -> list[str]:
    """Return lines that say how many of ``count`` things are left out, and of what; nothing where none is.

    >>> more(5, 3, "  "), more(3, 3), more(4, 2, of=["F1", "F2"])
    (['  and 2 more: -v lists them.'], [], ['and 2 more, of F1, F2: -v lists them.'])
    """
    names = f", of {named(of)}" if of else ""
    return folded(f"and {count - most} more{names}: -v lists them.", indent, width) if count > most else []


def about(names: Iterable[str], words: str) -> str:
    """Return words with the names they are about before them, but for those that they say themselves.

    >>> about(["Top A", "F1"], "F1 ends short."), about(["F1"], "F10 ends short.")
    ('Top A: F1 ends short.', 'F1: F10 ends short.')
    """
    missing = unsaid(names, words)
    return f"{named(missing)}: {words}" if missing else words


def unsaid(names: Iterable[str], words: str) -> list[str]:
    """Return the names that words do not say.

    >>> unsaid(["F1", "F2", "F6"], "F1 is cut by F6 (2).")
    ['F2', 'F6']
    """
    # "F6 (2)" is what repair calls a part of F6, and another fault than F6
    return [name for name in names if not re.search(rf"(?<!\w){re.escape(name)}(?!\w| \(\d)", words)]


def counts(names: Iterable[str]) -> str:
    """Return how often each name occurs, in the order of the first of each.

    >>> counts(["trace", "min-dip", "trace"])
    'trace 2, min-dip 1'
    """
    listed = list(names)
    return ", ".join(f"{name} {listed.count(name)}" for name in dict.fromkeys(listed))
