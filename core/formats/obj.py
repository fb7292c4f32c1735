"""OBJ files: vertices and faces; materials, normals and textures are passed over.

Read here: trimesh counts negative indices from the end of the file instead of from the face, takes 0 for 1,
does not see lines that begin with blanks or have tabs, and copies vertices that have several normals.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from graben.arrays import FloatArray, floats, ints
from graben.errors import InputError
from graben.formats.parts import Part, fans
from graben.formats.text import decoded, shortened
from graben.words import plural

_OBJECT = re.compile(r"^[ \t]*o[ \t]+\S", re.MULTILINE)


@dataclass
class _Faces:
    """The faces of one object or group: vertices counted from 0, and for each face its corners and line."""

    corners: list[int] = field(default_factory=list)
    counts: list[int] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)

    def add(self, corners: list[int], line: int) -> None:
        self.corners += corners
        self.counts.append(len(corners))
        self.lines.append(line)


def read_obj(path: Path, content: bytes) -> list[Part]:
    """Read the objects (o) of an OBJ file, in a file without any its groups (g).

    Parameters
    ----------
    path : Path
        The file, for messages.
    content : bytes
        What it holds.

    Raises
    ------
    InputError
        When a vertex or face cannot be read; names the line.
    """
    text = decoded(content, path)
    by_object = _OBJECT.search(text) is not None
    vertices: list[list[float]] = []
    groups: dict[tuple[int, str], _Faces] = {}
    part = (0, "")
    for number, line in _continued(text):
        key, *words = line.partition("#")[0].split() or [""]
        if key == "v":
            vertices.append(_vertex(words, path, number))
        elif key == "f":
            groups.setdefault(part, _Faces()).add(_corners(words, len(vertices), path, number), number)
        elif key == ("o" if by_object else "g"):
            # The name is all that follows. A group goes on where its name comes again, an object does not.
            part = (number if by_object else 0, line.strip()[1:].strip())
    places = floats(vertices, -1, 3)
    return [_part(name, places, faces, len(groups) == 1, path) for (_, name), faces in groups.items()]


def _part(name: str, vertices: FloatArray, faces: _Faces, alone: bool, path: Path) -> Part:
    """Return the surface of some faces; of several in a file each has the vertices that it uses."""
    corners, counts = ints(faces.corners), ints(faces.counts)
    beyond = np.flatnonzero(corners >= len(vertices))
    if len(beyond):
        line = faces.lines[int(np.searchsorted(np.cumsum(counts), beyond[0], side="right"))]
        raise InputError(
            f"{path}, line {line}: a face names vertex {corners[beyond[0]] + 1} of {len(vertices)}; export "
            "it again."
        )
    triangles = corners[fans(ints(np.concatenate([[0], np.cumsum(counts)])))]
    lines = ints(np.repeat(ints(faces.lines), counts - 2))
    if alone:
        return Part(name, vertices, triangles, lines)
    used, index = np.unique(triangles, return_inverse=True)
    return Part(name, vertices[used], index.reshape(-1, 3), lines)


def _continued(text: str) -> Iterator[tuple[int, str]]:
    """Yield the lines of a text with their numbers; those that end in a backslash go on in the next."""
    held, start = "", 0
    for number, line in enumerate(text.splitlines(), start=1):
        start = start or number
        if line.endswith("\\"):
            held += line[:-1] + " "
            continue
        yield start, held + line
        held, start = "", 0
    if held:
        yield start, held


def _vertex(words: list[str], path: Path, number: int) -> list[float]:
    try:
        place = [float(word) for word in words[:3]]
    except ValueError:
        found = shortened(" ".join(words))
        raise InputError(
            f"{path}, line {number}: a vertex holds {found} where numbers are due; correct it."
        ) from None
    if len(place) < 3:
        raise InputError(
            f"{path}, line {number}: a vertex has {plural(len(place), 'number')}, not 3; correct it."
        )
    return place


def _corners(words: list[str], count: int, path: Path, number: int) -> list[int]:
    """Return the vertices of a face, counted from 0; ``count`` vertices stand before it."""
    try:
        corners = [int(word.partition("/")[0]) for word in words]
    except ValueError:
        raise InputError(
            f"{path}, line {number}: a face holds {shortened(' '.join(words))} where whole numbers are due; "
            "correct it."
        ) from None
    corners = [count + 1 + c if c < 0 else c for c in corners]
    if len(corners) < 3 or min(corners) < 1:
        what = "fewer than three corners" if len(corners) < 3 else "a vertex before the first"
        raise InputError(f"{path}, line {number}: a face has {what}; correct it.")
    return [c - 1 for c in corners]
