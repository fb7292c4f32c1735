"""ZMAP+ grids (Landmark, GeoGraphix, RMS): text, without rotation, column by column from the north-west.

Format: David Baker on the gdal-dev mailing list, 27 June 2011. A line that begins with ! is a comment.
Between two lines that begin with @ stand, parted by commas:

- a name, the word GRID, the number of values in a line
- the width of a value, the number and the text that mean undefined, the decimals of a value without a point,
  where a line begins
- the numbers of rows and columns, the extents in x and y

Why it is read here: ``docs/decisions/0002-formats.md``.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from graben.arrays import FloatArray, floats
from graben.errors import InputError
from graben.formats.text import load_text, shortened
from graben.model import GridGeometry
from graben.words import plural

_COMMENTS = "!+"
_MARK = "@"
#: A line of the body with its number.
_Line = tuple[int, str]


@dataclass(frozen=True)
class _Header:
    """What the header says of the values; ``null`` and ``null_text`` are what an undefined node holds."""

    width: int
    null: float | None
    null_text: str
    decimals: int
    start: int
    grid: GridGeometry


def is_zmap(text: str) -> bool:
    """Return whether the first line of a text that is no comment begins with the @ of a ZMAP+ header.

    >>> is_zmap("! a comment\\n@GRID FILE, GRID, 4\\n"), is_zmap("1 2 3")
    (True, False)
    """
    lines = (line.strip() for line in text.splitlines())
    first = next((line for line in lines if line and line[0] not in _COMMENTS), "")
    return first.startswith(_MARK)


def read_zmap(path: Path) -> tuple[GridGeometry, FloatArray]:
    """Read a ZMAP+ grid.

    Values may stand one after another, parted by blanks, or in fields of the width that the header states.
    Where no value has a decimal point, the header's decimals say where it would stand.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    geometry : GridGeometry
        The extents of the header are taken for the places of the outer nodes.
    values : (columns, rows) array
        From the south-west, as the file counts them, NaN where undefined.

    Raises
    ------
    InputError
        When the file is no such grid, is cut short, or holds a word that is no number; names the line.
    """
    head, body = _parted(load_text(path), path)
    header = _header(head, path)
    columns, rows = header.grid.columns, header.grid.rows
    words = _words(body, header)
    if len(words) != columns * rows:
        raise InputError(
            f"{path}: the header says {columns} x {rows} = {columns * rows} nodes but {len(words)} values "
            "follow; export the grid again."
        )
    # A column runs from north to south.
    values = _numbers(words, header, path).reshape(columns, rows)[:, ::-1]
    return header.grid, floats(values)


def _parted(text: str, path: Path) -> tuple[list[_Line], list[_Line]]:
    """Return the lines of the header and those of the values, without comments and empty lines."""
    lines = [(k, line) for k, line in enumerate(text.splitlines(), start=1) if line.strip()]
    lines = [(k, line) for k, line in lines if not _is_comment(line.strip())]
    marks = [place for place, (_, line) in enumerate(lines) if line.lstrip().startswith(_MARK)]
    if not marks or marks[0] != 0:
        found = shortened(lines[0][1].strip()) if lines else "nothing"
        raise InputError(f"{path}: a ZMAP+ grid begins with a line '@name, GRID, 5', not {found}.")
    if len(marks) == 1:
        raise InputError(f"{path}: no second line with @ ends the header; export the ZMAP+ grid again.")
    first, second = marks[:2]
    number, line = lines[first]
    head = [(number, line.strip().removeprefix(_MARK)), *lines[first + 1 : second]]
    # The @ may have a line of its own.
    return [(k, line) for k, line in head if line.strip()], lines[second + 1 :]


def _is_comment(line: str) -> bool:
    """Return whether a line is a comment: RMS begins them with +, which may also begin a number."""
    return line[0] in _COMMENTS and not (line[0] == "+" and line[1:2].isdigit())


def _header(lines: list[_Line], path: Path) -> _Header:
    if len(lines) < 3:
        raise InputError(
            f"{path}: the header of the ZMAP+ grid has {len(lines)} lines, not 4; export it again."
        )
    _reject_other(lines[0], path)
    width, null, text, decimals, start = _fields(lines[1], 5, path)
    rows, columns, *extents = _fields(lines[2], 6, path)
    count = [_whole(word, what, lines[2][0], path) for word, what in ((columns, "columns"), (rows, "rows"))]
    number = None
    try:
        number = float(null) if null else None
        low_x, high_x, low_y, high_y = map(float, extents)
    except ValueError:
        wrong = f"{null}, {', '.join(extents)}"
        raise InputError(
            f"{path}: the header of the ZMAP+ grid holds {shortened(wrong, 80)} where numbers are due (what "
            f"undefined nodes hold, line {lines[1][0]}; the extents, line {lines[2][0]}); correct it."
        ) from None
    if not (np.isfinite([low_x, high_x, low_y, high_y]).all() and low_x < high_x and low_y < high_y):
        raise InputError(
            f"{path}, line {lines[2][0]}: the extents of the ZMAP+ grid must be finite, the lesser first; "
            "correct them."
        )
    dx, dy = (high_x - low_x) / (count[0] - 1), (high_y - low_y) / (count[1] - 1)
    plain = [
        _whole(word, what, lines[1][0], path, 0)
        for word, what in ((width, "characters of a value"), (decimals, "decimals"), (start, "the start"))
    ]
    grid = GridGeometry(count[0], count[1], dx, dy, (low_x, low_y))
    return _Header(plain[0], number, text, plain[1], max(plain[2], 1), grid)


def _reject_other(line: _Line, path: Path) -> None:
    """Raise unless the first line of a header says that a grid follows."""
    words = [word.strip() for word in line[1].split(",")]
    if "GRID" not in (word.upper() for word in words[1:]):
        found = shortened(words[1]) if len(words) > 1 else "nothing"
        raise InputError(
            f"{path}, line {line[0]}: after the name must stand GRID, not {found}; export the horizon as a "
            "grid."
        )


def _fields(line: _Line, count: int, path: Path) -> list[str]:
    """Return the fields of a header line, which may end in a comma."""
    words = [word.strip() for word in line[1].split(",")]
    if len(words) == count + 1 and not words[-1]:
        words.pop()
    if len(words) != count:
        raise InputError(
            f"{path}, line {line[0]}: the header has {plural(len(words), 'field')} here, not {count}; "
            "correct it."
        )
    return words


def _whole(word: str, what: str, line: int, path: Path, least: int = 2) -> int:
    if not word.isdecimal() or int(word) < least:
        raise InputError(
            f"{path}, line {line}: the number of {what} is {shortened(word)}, not a whole number of at least "
            f"{least}; correct it."
        )
    return int(word)


def _words(body: list[_Line], header: _Header) -> list[tuple[int, str]]:
    """Return the values as words with their lines: parted by blanks, else cut from fields of one width."""
    words = [(k, word) for k, line in body for word in line.split()]
    nodes = header.grid.columns * header.grid.rows
    if (len(words) == nodes and all(len(w) <= header.width for _, w in words)) or header.width == 0:
        return words
    first, width = header.start - 1, header.width
    cut = [
        (k, line[place : place + width].strip())
        for k, line in body
        for place in range(first, len(line.rstrip()), width)
    ]
    return cut if len(cut) == nodes else words


def _numbers(words: list[tuple[int, str]], header: _Header, path: Path) -> FloatArray:
    """Return the values, shape (n,), NaN where undefined."""
    undefined = np.array([word == header.null_text for _, word in words])
    try:
        raw = np.array(["nan" if u else w for u, (_, w) in zip(undefined, words, strict=True)], dtype=float)
    except ValueError:
        raise _no_number(words, header, path) from None
    if header.null is not None:
        # Programs write it with fewer digits, or from 32-bit numbers.
        with np.errstate(over="ignore"):
            undefined |= raw.astype(np.float32) == np.float32(header.null)
    scale = _scale([w for u, w in zip(undefined, words, strict=True) if not u], header, path)
    return floats(np.where(undefined, np.nan, raw / scale))


def _scale(words: list[tuple[int, str]], header: _Header, path: Path) -> float:
    """Return what values are divided by: 10 to the header's decimals where none has a decimal point."""
    packed = [(k, w) for k, w in words if w.lstrip("+-").isdecimal() and int(w) != 0]
    if header.decimals == 0 or not packed:
        return 1.0
    if any("." in word for _, word in words):
        line, word = packed[0]
        raise InputError(
            f"{path}, line {line}: {shortened(word)} has no decimal point while others have; by its header "
            f"such a value is divided by 10 to the {header.decimals}, so write all with a point."
        )
    return float(10.0**header.decimals)


def _no_number(words: list[tuple[int, str]], header: _Header, path: Path) -> InputError:
    for line, word in words:
        try:
            float("nan" if word == header.null_text else word)
        except ValueError:
            found = shortened(word) if word else "a blank field"
            return InputError(f"{path}, line {line}: {found} is no number; correct it.")
    raise AssertionError("words that do not convert hold one that does not")
