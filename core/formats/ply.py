"""PLY files, ASCII and binary, through trimesh.

trimesh says nothing of rows that are missing at the end of an ASCII file, or of corners that are missing in a
row, and takes all polygons of a binary file for ones with as many corners as the first. Such files are
refused, before or after it has read them.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from graben.errors import InputError
from graben.formats.parts import Part, loaded
from graben.formats.text import decoded

_END = re.compile(rb"^end_header[ \t]*\r?\n", re.MULTILINE)
#: The lines of a header that say how the rows are to be read.
_KNOWN = ("ply", "format", "element", "property")
_MIXED = (
    "its polygons differ in their number of corners, which binary PLY is read without; export it as triangles"
)


def read_ply(path: Path, content: bytes) -> list[Part]:
    """Read the surface of a PLY file.

    Parameters
    ----------
    path : Path
        The file, for messages.
    content : bytes
        What it holds.

    Raises
    ------
    InputError
        When rows or corners are missing, or the polygons of a binary file differ. Other damage leads trimesh
        to errors of any kind.
    """
    end = _END.search(content)
    if end is None:
        raise InputError(f"{path} has no line end_header, so the file is cut short; export it again.")
    header = [line.split() for line in decoded(content[: end.start()], path).splitlines()]
    header = [words for words in header if words and words[0] in _KNOWN]
    is_ascii = any(words[:2] == ["format", "ascii"] for words in header)
    body = content[end.end() :]
    if is_ascii:
        # The digits are there, so they count, also where the header speaks of 32-bit numbers.
        header = [_doubled(words) for words in header]
        rows = [line for line in body.splitlines() if line.strip()]
        body = b"\n".join(rows)
        if _ends_early(header, rows):
            raise InputError(f"{path}: its last row is too short, so the file is cut short; export it again.")
    head = "\n".join(" ".join(words) for words in header)
    try:
        meshes = loaded(f"{head}\nend_header\n".encode() + body, "ply", fix_texture=False)
    except ValueError as error:
        if is_ascii:
            raise
        raise InputError(f"{path} cannot be read: it is cut short or damaged, or {_MIXED}.") from error
    for mesh in meshes.values():
        _reject_rows(path, mesh.metadata["_ply_raw"])
    return [Part("", mesh.vertices, mesh.faces) for mesh in meshes.values()]


def _ends_early(header: list[list[str]], rows: list[bytes]) -> bool:
    """Return whether the last row of an ASCII file is that of a face and lacks corners."""
    count = next(int(words[2]) for words in reversed(header) if words[:1] == ["element"])
    words = rows[-1].split() if rows and count else []
    return header[-1][:2] == ["property", "list"] and bool(words) and len(words) <= int(words[0])


def _doubled(words: list[str]) -> list[str]:
    is_float = words[:1] == ["property"] and len(words) == 3 and words[1] in ("float", "float32")
    return ["property", "double", words[2]] if is_float else words


def _reject_rows(path: Path, elements: dict[str, Any]) -> None:
    """Raise for rows that trimesh has passed over or misread; ``elements`` are the tables as it read them."""
    for name in ("vertex", "face"):
        table = elements[name]["data"]
        columns = [table[key] for key in (table if isinstance(table, dict) else table.dtype.names)]
        for column in columns:
            if len(column) != elements[name]["length"]:
                raise InputError(
                    f"{path} has {len(column)} of {elements[name]['length']} rows of its element {name}, so "
                    "the file is cut short; export it again."
                )
            if column.dtype == object and min(map(len, column)) < 3:
                raise InputError(f"{path}: a face has fewer than three corners; export it again.")
            # Lists of a binary file are pairs of a count and that many numbers.
            if column.dtype.names and np.ptp(column["f0"]):
                raise InputError(f"{path} cannot be read: {_MIXED}.")
