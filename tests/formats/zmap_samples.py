"""ZMAP+ texts of one grid in many dialects, and a writer for more."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graben.arrays import FloatArray, floats
from graben.model import GridGeometry

GRID = GridGeometry(4, 3, 25.0, 50.0, (465_000.5, 5_932_000.25))
#: (columns, rows), from the south-west; one undefined node.
VALUES = floats(
    [
        [-1700.25, -1701.5, -1702.75],
        [-1710.0, np.nan, -1712.5],
        [-1720.125, -1721.0, -1722.0],
        [-1.5, -2.5, 0],
    ]
)


def zmap_text(
    grid: GridGeometry,
    values: FloatArray,
    *,
    per_line: int = 5,
    width: int = 15,
    decimals: int = 4,
    null: str = "0.1000000E+31",
    null_text: str = "",
    start: int = 1,
    name: str = "graben HEADER",
    comments: Sequence[str] = ("! ZMAP+ grid", "!"),
    packed: bool = False,
    digits: bool = False,
    run_on: bool = False,
) -> str:
    """Return a grid without rotation as a ZMAP+ text.

    ``packed`` leaves the decimal point out, ``digits`` writes every number with all that it has, ``run_on``
    begins no new line where a column does.
    """
    low, step = grid.origin, (grid.dx, grid.dy)
    high = [low[k] + (n - 1) * step[k] for k, n in enumerate((grid.columns, grid.rows))]
    lines = [
        *comments,
        f"@{name}, GRID, {per_line}",
        f"{width}, {null}, {null_text}, {decimals}, {start}",
        f"{grid.rows}, {grid.columns}, {low[0]!r}, {high[0]!r}, {low[1]!r}, {high[1]!r}",
        "0.0, 0.0, 0.0",
        "@",
    ]

    def word(value: float) -> str:
        if np.isnan(value):
            return (null or null_text).rjust(width)
        if packed:
            return f"{round(value * 10**decimals)}".rjust(width)
        return repr(value).rjust(width) if digits else f"{value:{width}.{decimals}f}"

    southward = values[:, ::-1]
    for column in (southward.reshape(1, -1) if run_on else southward).tolist():
        rows = (column[k : k + per_line] for k in range(0, len(column), per_line))
        lines += [" " * (start - 1) + "".join(map(word, row)) for row in rows]
    return "\n".join([*lines, ""])


PLAIN = zmap_text(GRID, VALUES)

#: All hold the grid above.
SAME: dict[str, str] = {
    "as RMS writes it": PLAIN,
    "a mark after the header (+)": PLAIN.replace("\n@\n", "\n@\n+Grid data starts after this line\n"),
    "header lines that end in a comma": PLAIN.replace("4, 1\n", "4, 1,\n").replace("0.0\n@", "0.0,\n@"),
    "no comment, @ in a line of its own": zmap_text(GRID, VALUES, comments=()).replace(
        "@graben", "@\ngraben"
    ),
    "a comment in the header and the values": PLAIN.replace("15, 0.1", "! note\n15, 0.1").replace(
        "\n@\n", "\n@\n! values\n"
    ),
    "two values in a line": zmap_text(GRID, VALUES, per_line=2),
    "lines that run over columns": zmap_text(GRID, VALUES, run_on=True),
    "null -99999": zmap_text(GRID, VALUES, null="-99999.0000"),
    "null as text": zmap_text(GRID, VALUES, null="", null_text="NULL"),
    "null with other digits than in the header": PLAIN.replace("15, 0.1000000E+31", "15, 1e30"),
    "null as 32-bit number": PLAIN.replace("15, 0.1000000E+31", "15, 1.0000000150474662e+30"),
    "null left blank": zmap_text(GRID, VALUES, null="", null_text="X")
    .replace("X, 4", ", 4")
    .replace("X", " "),
    "fields without a blank between": zmap_text(GRID, VALUES, width=10, null="-9999.0000"),
    "fields from the third character": zmap_text(GRID, VALUES, width=10, null="-9999.0000", start=3),
    "no decimal points": zmap_text(GRID, VALUES, packed=True, null="-99999"),
    "Windows line ends": PLAIN.replace("\n", "\r\n"),
    "exponents": zmap_text(GRID, VALUES, digits=True).replace("-1710.0", "-1.71E+03"),
}
