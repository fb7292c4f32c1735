"""File names for objects of any name."""

from __future__ import annotations

import re
from collections.abc import Iterable

_LONGEST = 80


def file_names(names: Iterable[str]) -> list[str]:
    """Return a file name, without suffix, for each name; no two are the same, whatever the case.

    Characters outside [A-Za-z0-9._-] become ``_``, and so do dots at the beginning, which would hide the
    file; names are cut at 80 characters, and clashes get -2, -3.

    >>> file_names(["Top A", "Top/A", "top_a"])
    ['Top_A', 'Top_A-2', 'top_a-3']
    >>> file_names(["../../etc/A", ".", "F.1"])
    ['___.._etc_A', '_', 'F.1']
    """
    taken: set[str] = set()
    result = []
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9._-]", "_", name)[:_LONGEST]
        plain = re.sub(r"^\.+", lambda dots: "_" * len(dots.group()), plain)
        candidate, count = plain, 1
        while candidate.lower() in taken:
            count += 1
            ending = f"-{count}"
            candidate = plain[: _LONGEST - len(ending)] + ending
        taken.add(candidate.lower())
        result.append(candidate)
    return result
