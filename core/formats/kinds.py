"""Which kind of file a file is, by its content; names and suffixes count only where that says nothing."""

from __future__ import annotations

import re
from enum import StrEnum
from pathlib import Path

from graben.formats.irap import is_irap_ascii, is_irap_binary
from graben.formats.sticks import has_stick_ends
from graben.formats.stl import is_binary_stl
from graben.formats.text import decoded, is_text, load_bytes
from graben.formats.zmap import is_zmap


class Kind(StrEnum):
    """A kind of input file; the value is what a user calls it."""

    TSURF = "GOCAD TSurf"
    IRAP_BINARY = "Irap classic binary grid"
    IRAP_ASCII = "Irap classic ASCII grid"
    ZMAP = "ZMAP+ grid"
    STICKS = "fault sticks"
    TABLE = "table of points"
    OBJ = "OBJ mesh"
    PLY = "PLY mesh"
    STL = "STL mesh"
    VTP = "VTK polygon file"


#: Kinds that hold one regular grid.
GRIDS = frozenset({Kind.IRAP_BINARY, Kind.IRAP_ASCII, Kind.ZMAP})
#: Mesh files: they hold triangulated surfaces and say nothing of the sign of z.
MESHES = frozenset({Kind.OBJ, Kind.PLY, Kind.STL, Kind.VTP})
#: Kinds that hold triangulated surfaces.
SURFACES = MESHES | {Kind.TSURF}

#: How much of a file is looked at to tell its kind, bytes.
_HEAD = 65_536
_OBJ_LINE = re.compile(rb"(?:v|vn|vt|vp|f|l|p|o|g|s|usemtl|mtllib)(?=\s|$)")
#: What begins a line of a TSurf file, of a ZMAP+ grid or of a table of numbers, whatever the file is called.
_OTHER_LINE = re.compile(rb"GOCAD\b|[-+.\d@!]")


def kind_of(path: Path) -> Kind:
    """Return the kind of a file.

    A table in which lines of 999s occur holds sticks. A table with a fourth column may hold points or
    sticks: it counts as points, and is taken for sticks where a fault is asked for. The suffix of a mesh
    file counts only where the content says nothing, so that a damaged one is called what it was.

    Raises
    ------
    InputError
        When the file is missing, empty, a folder, or binary and of no known kind.
    """
    content = load_bytes(path)
    mesh = _mesh_kind(content, path)
    if mesh is not None:
        return mesh
    if is_irap_binary(content):
        return Kind.IRAP_BINARY
    text = decoded(content, path)
    if text.lstrip().upper().startswith("GOCAD"):
        return Kind.TSURF
    if is_irap_ascii(content):
        return Kind.IRAP_ASCII
    if is_zmap(text[:_HEAD]):
        return Kind.ZMAP
    return Kind.STICKS if has_stick_ends(text) else Kind.TABLE


def _mesh_kind(content: bytes, path: Path) -> Kind | None:
    head = content[:_HEAD].removeprefix(b"\xef\xbb\xbf").lstrip()
    lines = (line.strip() for line in head.splitlines())
    first = next((line for line in lines if line and not line.startswith(b"#")), b"")
    if first == b"ply":
        return Kind.PLY
    if b"<VTKFile" in head and head.startswith(b"<"):
        return Kind.VTP
    if is_binary_stl(content) or (head[:5].lower() == b"solid" and b"facet" in head.lower()):
        return Kind.STL
    if _OBJ_LINE.match(first) and is_text(content):
        return Kind.OBJ
    if (_OTHER_LINE.match(first) and is_text(content)) or is_irap_binary(content):
        return None
    return {f".{kind.name.lower()}": kind for kind in sorted(MESHES)}.get(path.suffix.lower())
