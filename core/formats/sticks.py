"""Fault sticks: text files of picked lines down a fault."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from graben.arrays import FloatArray, floats
from graben.errors import InputError
from graben.formats.points import read_table

#: What all three numbers of a line are that ends a stick.
END = 999.0
_END_LINE = re.compile(r"^[ \t]*999(?:\.0*)?[ \t,;]+999(?:\.0*)?[ \t,;]+999(?:\.0*)?[ \t]*\r?$", re.MULTILINE)
_NUMBER_NAMES = ("stick", "stick_number", "stick_id", "poly_id", "segment_id")


def has_stick_ends(text: str) -> bool:
    """Return whether a text holds a line of 999s, which ends a stick.

    >>> has_stick_ends("1 2 3\\n999.0 999.0 999.0\\n"), has_stick_ends("1 999 3")
    (True, False)
    """
    return _END_LINE.search(text) is not None


def read_sticks(path: Path) -> list[FloatArray]:
    """Read fault sticks: lines of x y z with a line of 999s after each stick, or x y z and a stick number.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    list of (k, 3) arrays
        The sticks in the order of the file (sticks with numbers: of first occurrence), as the file counts
        z, with every point as it stands.

    Raises
    ------
    InputError
        When a line cannot be read, or nothing tells one stick from the next.
    """
    table = read_table(path, ("x", "y", "z"), optional=_NUMBER_NAMES)[0]
    points = table[:, :3]
    ends = (points == END).all(axis=1)
    if ends.any():
        label = np.cumsum(ends)
    elif table.shape[1] > 3:
        label = np.unique(table[:, 3], return_inverse=True)[1].ravel()
    else:
        raise InputError(
            f"{path} holds points, but nothing tells one fault stick from the next; end each stick with a "
            "line of 999s, or add a column with the number of the stick."
        )
    names, first = np.unique(label[~ends], return_index=True)
    return [floats(points[(label == name) & ~ends]) for name in names[np.argsort(first)]]
