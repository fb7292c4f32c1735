"""Words for counts."""

from __future__ import annotations


def plural(count: int, noun: str, many: str = "") -> str:
    """Return a count with its noun.

    >>> plural(1, "fault"), plural(2, "fault"), plural(2, "vertex", "vertices")
    ('1 fault', '2 faults', '2 vertices')
    """
    return f"{count} {noun if count == 1 else many or noun + 's'}"
