"""Points and other tables of numbers: CSV with a header, or bare columns."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.errors import InputError
from graben.formats.text import load_text, shortened

_AXES = ("x", "y", "z")
_COMMENT = "#"


def read_points(path: Path) -> FloatArray:
    """Read points: a CSV with a header and ``,`` or ``;``, or bare columns.

    The columns X, Y, Z are found by name, in any case and order; without a header they are the first three.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    (n, 3) array
        As the file counts z. Numbers that are not finite (nan, inf) are kept.

    Raises
    ------
    InputError
        When a column or a number is missing; names the line.
    """
    return read_table(path, _AXES)[0]


def read_table(
    path: Path, columns: Sequence[str], optional: Sequence[str] = ()
) -> tuple[FloatArray, IntArray]:
    """Read named columns of a table of numbers.

    Parameters
    ----------
    path : Path
        The file.
    columns : sequence of str
        Names in small letters, found in the header in any case, or the first columns of a bare table.
    optional : sequence of str
        Further names, of which the first found gives one more column; in a bare table the next column,
        where there is one.

    Returns
    -------
    table : (n, k) array
        k = ``len(columns)``, or one more where an optional column is there.
    lines : (n,) array
        Line of each row, 1-based.
    """
    lines = load_text(path).splitlines()
    numbers = [k for k, line in enumerate(lines, start=1) if line.strip() and not _is_comment(line)]
    if not numbers:
        raise InputError(f"{path} holds no table; export the points again.")
    first = lines[numbers[0] - 1]
    separator = next((mark for mark in ";," if mark in first), None)
    if _is_row(first, separator):
        width = len(first.split(separator))
        places = list(range(len(columns) + (1 if optional and width > len(columns) else 0)))
    else:
        places = _places(first.split(separator), columns, optional, numbers.pop(0), path)
    if not numbers:
        raise InputError(f"{path} holds a header but no points; export the points again.")
    rows = [lines[k - 1] for k in numbers]
    try:
        # loadtxt, not pandas: pandas fills a row that is cut short with NaN and says nothing.
        text = io.StringIO("\n".join(rows))
        table = np.loadtxt(text, delimiter=separator, usecols=places, ndmin=2, comments=None)
    except ValueError:
        wanted = dict(zip(places, [*columns, "number"], strict=False))
        number, what = _bad_row(rows, numbers, separator, wanted)
        raise InputError(f"{path}, line {number}: {what}.") from None
    return floats(table), ints(numbers)


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith(_COMMENT)


def _is_row(line: str, separator: str | None) -> bool:
    """Return whether a line is a row of numbers, not a header: its first word reads as a number."""
    try:
        float(line.split(separator, maxsplit=1)[0])
    except ValueError:
        return False
    return True


def _places(
    header: list[str], columns: Sequence[str], optional: Sequence[str], number: int, path: Path
) -> list[int]:
    """Return the columns of a header that hold what is asked for."""
    names = [word.strip().strip('"').lower() for word in header]
    for name in columns:
        if name not in names:
            found = ", ".join(shortened(word.strip()) for word in header[:8])
            raise InputError(
                f"{path}, line {number}: no column {name.upper()} in the header ({found}); name the columns "
                "X, Y and Z, or leave the header out."
            )
        if names.count(name) > 1:
            raise InputError(f"{path}, line {number}: the column {name.upper()} is there twice; rename one.")
    more = [names.index(name) for name in optional if name in names]
    return [names.index(name) for name in columns] + more[:1]


def _bad_row(
    rows: list[str], numbers: list[int], separator: str | None, wanted: dict[int, str]
) -> tuple[int, str]:
    """Return the line of the first row that is no row of numbers, and what is wrong with it."""
    for row, number in zip(rows, numbers, strict=True):
        words = [word.strip() for word in row.split(separator)]
        for place, name in wanted.items():
            if place >= len(words):
                return number, f"{name.upper()} is column {place + 1} but there are {len(words)}; complete it"
            try:
                float(words[place])
            except ValueError:
                found = shortened(words[place]) if words[place] else "empty"
                return number, f"{name.upper()} is {found}, not a number; correct it"
    return numbers[0], "the rows from here on are no table of numbers; export the points again"
