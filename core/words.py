"""Words for counts."""

from __future__ import annotations

from collections.abc import Sequence


def plural(count: int, noun: str, many: str = "") -> str:
    """Return a count with its noun.

    >>> plural(1, "fault"), plural(2, "fault"), plural(2, "vertex", "vertices")
    ('1 fault', '2 faults', '2 vertices')
    """
    return f"{count} {noun if count == 1 else many or noun + 's'}"


def listed(names: Sequence[str], most: int = 4) -> str:
    """Return names in a row; of more than ``most``, the first of them and how many are left.

    >>> listed(["A"]), listed(["A", "B", "C"]), listed(["A", "B", "C", "D"], most=2)
    ('A', 'A, B and C', 'A, B and 2 more')
    """
    shown = [*names] if len(names) <= most else [*names[:most], f"{len(names) - most} more"]
    return " and ".join([part for part in (", ".join(shown[:-1]), shown[-1]) if part])
