"""Findings as a pandas table."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas

    from graben.finding import CheckResult

COLUMNS = (
    *("check", "status", "objects", "count", "value", "unit", "x", "y", "z"),
    *("message", "remedy", "repairable"),
)


def findings_table(result: CheckResult) -> pandas.DataFrame:
    """Return the findings of a check, one row each, in their order.

    ``objects`` holds names parted by "; "; ``value``, ``unit``, ``x``, ``y``, ``z`` are those of the worst,
    NaN where there is none. z is elevation.
    """
    import pandas

    rows: list[tuple[object, ...]] = []
    for f in result.findings:
        worst: tuple[object, ...] = (None, "", None, None, None)
        if f.worst is not None:
            worst = (f.worst.value, f.worst.unit, f.worst.x, f.worst.y, f.worst.z)
        said = (f.message, f.remedy, f.repairable)
        rows.append((f.check, str(f.status), "; ".join(f.objects), f.count, *worst, *said))
    table = pandas.DataFrame(rows, columns=list(COLUMNS))
    numbers = ["value", "x", "y", "z"]
    table[numbers] = table[numbers].astype("float64")
    return table
