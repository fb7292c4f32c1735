"""GOCAD TSurf files: every dialect of the format in, one plain dialect out.

An ATOM (PATOM) is read as the vertex it names: the file says that both are one place. A Model3d lists the
surfaces that follow it in the file; what it says of z and of them counts where they say nothing. Format:
Paradigm's ASCII object files; what other readers get wrong is in ``docs/decisions/0002-formats.md``.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.errors import InputError
from graben.formats.text import load_text, shortened
from graben.surface import Surface

Sign = Literal["elevation", "depth"]

# In a one-line header the name ends where the next key, such as "*solid*color:", or the brace begins.
_NAME = re.compile(r"(?:^|[\s{])\*?name\s*:\s*(\"[^\"]*\"|.*?)\s*(?=\s[*\w]+\s*:|}|$)", re.IGNORECASE)
_LARGEST_ID = 2**63 - 1
_SURFACE, _MODEL = "TSURF", "MODEL3D"


@dataclass(frozen=True, eq=False)
class TSurf:
    """One TSurf object of a file, as it stands there.

    Parameters
    ----------
    surface : Surface
        Elevations where the object states its sign of z, else the numbers of the file.
    z : "elevation", "depth" or None
        What ZPOSITIVE states; None where nothing is stated.
    named : bool
        Whether the object itself has a name (else the surface carries the file's).
    role : str
        What the file says that it is, in small letters, such as "fault" or "top"; empty where nothing.
    """

    surface: Surface
    z: Sign | None
    named: bool
    role: str = ""

    def upward(self, z: Sign) -> Surface:
        """Return the surface with elevations; ``z`` is taken for the sign where the object states none."""
        if self.z is not None or z == "elevation":
            return self.surface
        return self.surface.with_vertices(mirrored(self.surface.vertices))


@dataclass
class _Rows:
    """Lines of one kind, split into words, with their numbers."""

    words: list[list[str]] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)

    def add(self, words: list[str], line: int) -> None:
        self.words.append(words)
        self.lines.append(line)


@dataclass
class _Draft:
    """What has been read of an object so far; ``block`` is the { } block that is open.

    ``roles`` are those that a Model3d gives to surfaces, by their names.
    """

    kind: str
    start: int
    name: str = ""
    feature: str = ""
    role: str = ""
    z: Sign | None = None
    block: str = ""
    roles: dict[str, str] = field(default_factory=dict)
    vertices: _Rows = field(default_factory=_Rows)
    atoms: _Rows = field(default_factory=_Rows)
    triangles: _Rows = field(default_factory=_Rows)


def read_tsurf(path: Path) -> list[TSurf]:
    """Read every TSurf object of a GOCAD file.

    Coordinates that are not finite and triangles that name no vertex (index -1) are kept: the check
    ``finite`` reports them.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    list of TSurf
        In the order of the file; ``surface.lines`` holds the line of each triangle.

    Raises
    ------
    InputError
        When the file is no TSurf file, is cut short, or a line cannot be read.
    """
    surfaces: list[TSurf] = []
    others: set[str] = set()
    model = _Draft(_MODEL, 0)
    for draft in _drafts(load_text(path).splitlines(), path):
        if draft.kind.upper() == _SURFACE:
            surfaces.append(_finished(draft, model, path))
            continue
        others.add(shortened(draft.kind))
        if draft.kind.upper() == _MODEL:
            model = draft
    if not surfaces:
        what = f"holds {', '.join(sorted(others))} but no TSurf object" if others else "holds no TSurf object"
        raise InputError(f"{path} {what}; export triangulated surfaces.")
    return surfaces


def _drafts(lines: list[str], path: Path) -> list[_Draft]:
    """Split a file into its objects; what those of other kinds hold is passed over."""
    drafts: list[_Draft] = []
    draft: _Draft | None = None
    start = 0  # line in which the open object began; 0 between objects
    for number, line in enumerate(lines, start=1):
        words = line.split()
        if not words:
            continue
        key = words[0]
        if key == "GOCAD":
            if start:
                raise InputError(
                    f"{path}, line {number}: a new object begins before the END of that from line {start}, "
                    "so the file is damaged; export it again."
                )
            start = number
            drafts.append(_Draft(words[1] if len(words) > 1 else "", number))
            draft = drafts[-1] if drafts[-1].kind.upper() in (_SURFACE, _MODEL) else None
        elif key == "END" and start:
            start, draft = 0, None
        elif draft is not None:
            _take(draft, line.strip(), words, number, path)
        elif not start and not key.startswith("#"):
            raise InputError(
                f"{path}, line {number}: expected the first line of an object, 'GOCAD TSurf 1', but found "
                f"{shortened(line.strip())}; give a GOCAD ASCII file."
            )
    if start:
        raise InputError(
            f"{path}: the object from line {start} has no END, so the file is cut short; export it again."
        )
    return drafts


def _take(draft: _Draft, line: str, words: list[str], number: int, path: Path) -> None:
    """Take up one line of an object; lines of no interest here are passed over."""
    key = words[0]
    if key == "TRGL":
        draft.triangles.add(words, number)
    elif key in ("VRTX", "PVRTX"):
        draft.vertices.add(words, number)
    elif key in ("ATOM", "PATOM"):
        draft.atoms.add(words, number)
    elif "{" in line or draft.block:
        draft.block = draft.block or key.rstrip("{").upper()
        found = _NAME.search(line)
        if draft.block == "HEADER" and found and not draft.name:
            draft.name = _unquoted(found.group(1))
        if "}" in line:
            draft.block = ""
    elif key == "GEOLOGICAL_FEATURE":
        draft.feature = _unquoted(line[len(key) :])
    elif key == "GEOLOGICAL_TYPE":
        draft.role = _unquoted(line[len(key) :]).lower()
    elif key == "TFACE" and len(words) > 3:
        # In a Model3d: number, role and surface of a part.
        draft.roles[" ".join(words[3:])] = words[2].lower()
    elif key == "ZPOSITIVE":
        signs: dict[str, Sign] = {"elevation": "elevation", "depth": "depth"}
        sign = words[1] if len(words) > 1 else ""
        if sign.lower() not in signs:
            raise InputError(
                f"{path}, line {number}: ZPOSITIVE is {shortened(sign)}; it must be Elevation or Depth."
            )
        draft.z = signs[sign.lower()]


def _unquoted(text: str) -> str:
    return text.strip().strip('"').strip()


def _finished(draft: _Draft, model: _Draft, path: Path) -> TSurf:
    """Turn the words of an object into its surface; ``model`` is the Model3d that lists it."""
    if not draft.triangles.words:
        raise InputError(
            f"{path}: the object from line {draft.start} holds no triangle (TRGL); export it as a surface."
        )
    ids = _whole_numbers(draft.vertices, slice(1, 2), path).ravel()
    vertices = _coordinates(draft.vertices, path)
    atoms = _whole_numbers(draft.atoms, slice(1, 3), path)
    known = np.concatenate([ids, atoms[:, 0]])
    _reject_repeated(known, draft.vertices.lines + draft.atoms.lines, path)
    rows = np.concatenate([np.arange(len(ids)), _atom_rows(ids, atoms)])
    name, z = draft.name or draft.feature, draft.z or model.z
    surface = Surface(
        name or path.stem,
        mirrored(vertices) if z == "depth" else vertices,
        ints(_looked_up(known, rows, _whole_numbers(draft.triangles, slice(1, 4), path))),
        ints(draft.triangles.lines),
        path,
    )
    return TSurf(surface, z, bool(name), draft.role or model.roles.get(name, ""))


def mirrored(vertices: FloatArray) -> FloatArray:
    """Return vertices, shape (n, 3), with the sign of z changed."""
    return floats(vertices * np.array([1.0, 1.0, -1.0]), -1, 3)


def _atom_rows(ids: IntArray, atoms: IntArray) -> IntArray:
    """Return the row of the vertex behind each atom, -1 for none; atoms of atoms are followed."""
    rows = np.full(len(atoms), -1)
    for _ in range(len(atoms)):
        known = np.concatenate([ids, atoms[:, 0]])
        found = _looked_up(known, np.concatenate([np.arange(len(ids)), rows]), atoms[:, 1])
        if np.array_equal(found, rows):
            break
        rows = found
    return rows


def _looked_up(known: IntArray, rows: IntArray, wanted: IntArray) -> IntArray:
    """Return ``rows`` at the places where ``known`` holds what is wanted, -1 where it does not."""
    if len(known) == 0:
        return np.full(wanted.shape, -1)
    order = np.argsort(known, kind="stable")
    place = order[np.minimum(np.searchsorted(known, wanted, sorter=order), len(known) - 1)]
    return np.where(known[place] == wanted, rows[place], -1)


def _whole(word: str) -> int:
    number = int(word)
    if abs(number) > _LARGEST_ID:
        raise ValueError(word)
    return number


def _whole_numbers(rows: _Rows, part: slice, path: Path) -> IntArray:
    flat = _converted(rows, part, _whole, "a whole number", path)
    return np.array(flat, dtype=np.int64).reshape(len(rows.words), -1 if rows.words else 2)


def _coordinates(rows: _Rows, path: Path) -> FloatArray:
    flat = _converted(rows, slice(2, 5), float, "a number", path)
    return np.array(flat, dtype=np.float64).reshape(-1, 3)


def _converted(
    rows: _Rows, part: slice, convert: Callable[[str], float], due: str, path: Path
) -> list[float]:
    """Convert the same part of each row of words, row after row, telling the line where that fails."""
    try:
        flat = [convert(word) for row in rows.words for word in row[part]]
    except ValueError:
        flat = []
    if len(flat) == len(rows.words) * (part.stop - part.start):
        return flat
    for row, number in zip(rows.words, rows.lines, strict=True):
        if len(row) < part.stop:
            raise InputError(
                f"{path}, line {number}: {row[0]} takes {part.stop - 1} numbers but has {len(row) - 1}; "
                "the line is cut short, export the file again."
            )
        for word in row[part]:
            try:
                convert(word)
            except ValueError:
                raise InputError(
                    f"{path}, line {number}: {row[0]} holds {shortened(word)} where {due} is due; correct it."
                ) from None
    raise AssertionError("rows that do not convert hold a row that does not")


def _reject_repeated(ids: IntArray, lines: list[int], path: Path) -> None:
    order = np.argsort(ids, kind="stable")
    twice = np.flatnonzero(ids[order][1:] == ids[order][:-1])
    if len(twice):
        first, second = order[twice[0]], order[twice[0] + 1]
        raise InputError(
            f"{path}, line {lines[second]}: the vertex id {ids[second]} was given in line {lines[first]} "
            "already; number the vertices anew."
        )
