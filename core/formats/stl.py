"""STL files, ASCII and binary, through trimesh.

trimesh passes over a solid without an end, and takes words for keywords in the names of solids. So solids are
given to it under numbers, and what it has read is counted.
"""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.errors import InputError
from graben.formats.parts import Part, loaded
from graben.formats.text import decoded, is_text

#: Bytes before the first triangle of a binary file, the last four of which count the triangles, and of each.
_HEAD, _COUNT, _TRIANGLE = 84, 80, 50
_FACET = re.compile(r"^\s*facet\b", re.MULTILINE | re.IGNORECASE)


def is_binary_stl(content: bytes) -> bool:
    """Return whether a file is as long as a binary STL of the number of triangles that it states."""
    return len(content) >= _HEAD and len(content) == _HEAD + _TRIANGLE * _stated(content)


def read_stl(path: Path, content: bytes) -> list[Part]:
    """Read an STL file: each solid of an ASCII file is a surface, a binary file is one.

    Parameters
    ----------
    path : Path
        The file, for messages.
    content : bytes
        What it holds.

    Raises
    ------
    InputError
        When solids, facets or triangles are missing. Other damage leads trimesh to errors of any kind.
    """
    if is_binary_stl(content):
        return [_merged("", floats(m.vertices), ints(m.faces)) for m in loaded(content, "stl").values()]
    if not is_text(content):
        there = max(0, len(content) - _HEAD) // _TRIANGLE
        raise InputError(
            f"{path} states {_stated(content)} triangles but has room for {there}, so the STL is damaged; "
            "export it again."
        )
    text, names = _numbered_solids(decoded(content, path), path)
    meshes = list(loaded(text.encode(), "stl").values())
    if len(_FACET.findall(text)) != sum(len(mesh.faces) for mesh in meshes):
        raise InputError(f"{path}: some facet has not three vertices of three numbers; export it again.")
    return [_merged(names[int(m.metadata["name"])], floats(m.vertices), ints(m.faces)) for m in meshes]


def _stated(content: bytes) -> int:
    count: int = struct.unpack_from("<I", content.ljust(_HEAD, b"\0"), _COUNT)[0]
    return count


def _numbered_solids(text: str, path: Path) -> tuple[str, list[str]]:
    """Return the text of an ASCII STL with numbers for the names of its solids, and the names."""
    names: list[str] = []
    ends = 0
    lines = text.splitlines()
    for k, line in enumerate(lines):
        key, _, name = line.strip().partition(" ")
        if key.lower() == "solid":
            lines[k] = f"solid {len(names)}"
            names.append(name.strip())
        elif key.lower() == "endsolid":
            lines[k] = "endsolid"
            ends += 1
        if not ends <= len(names) <= ends + 1:
            break
    if ends != len(names):
        raise InputError(
            f"{path} has {len(names)} solids but {ends} endsolid, so it is cut short; export it again."
        )
    return "\n".join([*lines, ""]), names


def _merged(name: str, vertices: FloatArray, triangles: IntArray) -> Part:
    """Return the surface with vertices equal to the bit (0 and -0 count as one) merged into the first."""
    # Zero is added, so that -0 becomes 0; the view compares bits, so that one NaN is one vertex.
    rows = np.ascontiguousarray(vertices + 0.0).view(np.int64)
    _, first, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    kept = np.sort(first)
    index = np.searchsorted(kept, first[inverse.reshape(-1)])
    return Part(name, vertices[kept], index[triangles])
