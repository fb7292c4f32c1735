"""Points and other tables of numbers: CSV with a header, or bare columns."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.errors import InputError
from graben.formats.text import load_text, shortened

_AXES = ("x", "y", "z")
#: What programs call the three columns where not X, Y and Z; small letters and digits alone, without units.
ALIASES = {
    "x": ("utmx", "xutm", "easting", "eastings", "east", "xcoord", "xcoordinate", "coordx", "cdpx"),
    "y": ("utmy", "yutm", "northing", "northings", "north", "ycoord", "ycoordinate", "coordy", "cdpy"),
    "z": ("tvdss", "tvd", "depth", "elevation", "elev", "twt", "twtt", "zcoord", "zcoordinate", "zvalue"),
}
_UNIT = re.compile(r"[(\[].*?[)\]]|_(?:m|ft|ms)$")
_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+(?:[eE][-+]?\d+)?")
_COMMENT = "#"


def read_points(path: Path) -> FloatArray:
    """Read points: a CSV with a header and ``,`` or ``;``, or bare columns.

    The columns X, Y, Z are found by name, in any case and order, or by what programs call them: Easting,
    UTM_X, Northing, UTM_Y, TVDSS, Depth, Elevation, TWT and the like, see ``ALIASES``. Without a header they
    are the first three.

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
    _reject_decimal_commas(first, numbers[0], path)
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


def header_units(path: Path) -> list[str]:
    """Return the units that the header of a table states with its columns X, Y and Z, as they stand there.

    They follow a name in brackets or behind a ``_``, as in "TVDSS (ft)"; bare columns state none.
    """
    with path.open("rb") as stream:
        lines = (line.decode("utf-8-sig", "replace") for line in stream)
        first = next((line for line in lines if line.strip() and not _is_comment(line)), "")
    separator = next((mark for mark in ";," if mark in first), None)
    words = [word.strip().strip('"').lower() for word in first.split(separator)]
    found = [(_plain(word), _UNIT.search(word)) for word in words]
    return [unit[0].strip("()[]_ ") for name, unit in found if unit and _axis_of(name)]


def _plain(word: str) -> str:
    """Return the name of a column without its unit, letters and digits alone."""
    return "".join(c for c in _UNIT.sub("", word) if c.isalnum())


def _axis_of(plain: str) -> str:
    """Return the axis that a plain name of a column stands for; empty for none."""
    return next((axis for axis in _AXES if plain == axis or plain in ALIASES[axis]), "")


def _reject_decimal_commas(line: str, number: int, path: Path) -> None:
    """Raise InputError where a line of bare columns has decimal commas, which would part columns."""
    words = line.split()
    if ";" not in line and len(words) > 2 and all(_DECIMAL_COMMA.fullmatch(word) for word in words[:3]):
        mend = words[0].replace(",", ".")
        raise InputError(
            f"{path}, line {number}: X is {shortened(words[0])}, with a decimal comma; write decimal points, "
            f"as in {mend}."
        )


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
    found = [_place_of(name, names, header, number, path) for name in columns]
    more = [names.index(name) for name in optional if name in names]
    return found + more[:1]


def _place_of(name: str, names: list[str], header: list[str], number: int, path: Path) -> int:
    """Return the column of a header that is called so, or by a name that stands for it."""
    if names.count(name) > 1:
        raise InputError(f"{path}, line {number}: the column {name.upper()} is there twice; rename one.")
    if name in names:
        return names.index(name)
    plain = [_plain(word) for word in names]
    alike = [k for k, word in enumerate(plain) if word == name or word in ALIASES.get(name, ())]
    if len(alike) > 1:
        both = " and ".join(shortened(header[k].strip()) for k in alike[:2])
        raise InputError(
            f"{path}, line {number}: the columns {both} may both be {name.upper()}; call the one that is "
            f"meant {name.upper()}."
        )
    if not alike:
        told = ", ".join(shortened(word.strip()) for word in header[:8])
        raise InputError(
            f"{path}, line {number}: no column {name.upper()} in the header ({told}); name the columns X, Y "
            "and Z (Easting, Northing, Depth, TVDSS, Elevation and TWT are known too), or leave the header "
            "out."
        )
    return alike[0]


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
                if _DECIMAL_COMMA.fullmatch(words[place]):
                    mend = "write decimal points, as in " + words[place].replace(",", ".")
                    return number, f"{name.upper()} is {found}, with a decimal comma; {mend}"
                return number, f"{name.upper()} is {found}, not a number; correct it"
    return numbers[0], "the rows from here on are no table of numbers; export the points again"
