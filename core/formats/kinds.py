"""Which kind of file a file is, by its content; names and suffixes are not asked."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path

from graben.formats.irap import is_irap_ascii, is_irap_binary
from graben.formats.sticks import has_stick_ends
from graben.formats.text import decoded, load_bytes


class Kind(StrEnum):
    """A kind of input file; the value is what a user calls it."""

    TSURF = "GOCAD TSurf"
    IRAP_BINARY = "Irap classic binary grid"
    IRAP_ASCII = "Irap classic ASCII grid"
    STICKS = "fault sticks"
    TABLE = "table of points"


def kind_of(path: Path) -> Kind:
    """Return the kind of a file.

    A table in which lines of 999s occur holds sticks. A table with a fourth column may hold points or
    sticks: it counts as points, and is taken for sticks where a fault is asked for.

    Raises
    ------
    InputError
        When the file is missing, empty, a folder, or binary and no Irap grid.
    """
    content = load_bytes(path)
    if is_irap_binary(content):
        return Kind.IRAP_BINARY
    text = decoded(content, path)
    if text.lstrip().upper().startswith("GOCAD"):
        return Kind.TSURF
    if is_irap_ascii(content):
        return Kind.IRAP_ASCII
    return Kind.STICKS if has_stick_ends(text) else Kind.TABLE
