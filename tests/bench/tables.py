"""What the benchmarks have in common: where the data are, and tables on the terminal."""

from __future__ import annotations

from pathlib import Path

DATA = Path(__file__).parents[3] / "shared" / "data"
OUT = Path(__file__).parents[2] / "build" / "bench"

#: Figures by case and column.
Table = dict[str, dict[str, float]]


def seconds_table(title: str, table: Table) -> None:
    """Print a table; whole numbers as such, others to the millisecond."""
    columns = list(dict.fromkeys(column for row in table.values() for column in row))
    wide = max([len(title), *(len(name) for name in table)]) + 2
    print(f"{title:<{wide}}" + "".join(f"{column:>16}" for column in columns))
    for name, row in table.items():
        cells = (row.get(column) for column in columns)
        print(f"{name:<{wide}}" + "".join(f"{_cell(value):>16}" for value in cells))


def _cell(value: float | None) -> str:
    if value is None:
        return ""
    return f"{value:d}" if isinstance(value, int) else f"{value:.3f}"
