"""Triangulated surfaces from mesh files: OBJ, PLY and STL through trimesh, VTP through pyvista.

trimesh passes in silence over part of what these formats allow: OBJ indices of 0, names with blanks at their
keyword, rows that are missing. Such files are brought to the form that it reads right, or refused, before or
after it has read them; ``docs/formats.md`` says what that means to a user.
"""

from __future__ import annotations

import io
import logging
import re
import struct
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.errors import InputError
from graben.formats.text import decoded, is_text, load_bytes, shortened
from graben.formats.tsurf import TSurf
from graben.surface import Surface


class MeshKind(StrEnum):
    """A kind of mesh file; the value is what a user calls it."""

    OBJ = "OBJ mesh"
    PLY = "PLY mesh"
    STL = "STL mesh"
    VTP = "VTK polygon file"


#: trimesh logs what it passes over, which without a handler would go to the terminal, traceback and all.
_SILENT = logging.NullHandler()
#: How much of a file is looked at to tell its kind, bytes.
_HEAD = 65_536
_BINARY_STL_HEAD, _BINARY_STL_TRIANGLE = 84, 50
_OBJ_LINE = re.compile(rb"(?:v|vn|vt|vp|f|l|p|o|g|s|usemtl|mtllib)(?=\s|$)")
#: What begins a line of a TSurf file or of a table of numbers, whatever the file is called.
_OTHER_LINE = re.compile(rb"GOCAD\b|[-+.\d]")
#: Elements that a byte of a VTP file may stand for: more than compression gives, so that a damaged count does
#: not make VTK end the process for want of memory.
_MOST_PER_BYTE = 100
_VTP_COUNT = re.compile(rb"NumberOf\w+\s*=\s*[\"']\s*(\d+)")
_MIXED = (
    "its polygons differ in their number of corners, which binary PLY is read without; export it as triangles"
)


@dataclass(frozen=True, eq=False)
class _Part:
    """One surface of a file; the name is empty where the file has none."""

    name: str
    vertices: ArrayLike
    triangles: ArrayLike


def mesh_kind_of(path: Path) -> MeshKind | None:
    """Return which kind of mesh file a file is, by its content; None for any other.

    The suffix counts only where the content says nothing, so that a damaged mesh file is called one.

    Raises
    ------
    InputError
        When the file is missing, empty or a folder.
    """
    return _kind(load_bytes(path), path)


def read_meshes(path: Path) -> list[TSurf]:
    """Read every surface of an OBJ, PLY, STL or VTP file.

    Polygons become fans of triangles from their first corner. Coordinates that are not finite are kept: the
    check ``finite`` reports them.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    list of TSurf
        In the order of the file, without a sign of z and without lines. Vertices keep the order of the file,
        those that no triangle uses included where the file holds one surface; of several each has those that
        it uses. Of an STL, vertices equal to the bit are one, in the place of the first.

    Raises
    ------
    InputError
        When the file is no mesh file, holds no triangle, is cut short or damaged, or a face names no vertex.
    """
    content = load_bytes(path)
    kind = _kind(content, path)
    if kind is None:
        raise InputError(f"{path} is no OBJ, PLY, STL or VTP file; give one of these.")
    readers = {MeshKind.OBJ: _obj, MeshKind.PLY: _ply, MeshKind.STL: _stl, MeshKind.VTP: _vtp}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            # Before version 2.4, numpy stops at a word that is no number with no more than this warning.
            warnings.filterwarnings("error", "string or file could not be read", DeprecationWarning)
            parts = readers[kind](path, content)
        surfaces = [_finished(path, part) for part in parts]
    except InputError:
        raise
    except Exception as error:  # the libraries raise whatever a damaged file leads them to
        raise InputError(
            f"{path} cannot be read: the {kind} is cut short or damaged; export it again."
        ) from error
    if not surfaces:
        raise InputError(f"{path} holds no face; export it as a triangulated surface.")
    return surfaces


def _kind(content: bytes, path: Path) -> MeshKind | None:
    head = content[:_HEAD].removeprefix(b"\xef\xbb\xbf").lstrip()
    lines = (line.strip() for line in head.splitlines())
    first = next((line for line in lines if line and not line.startswith(b"#")), b"")
    if first == b"ply":
        return MeshKind.PLY
    if b"<VTKFile" in head and head.startswith(b"<"):
        return MeshKind.VTP
    if _is_binary_stl(content) or (head[:5].lower() == b"solid" and b"facet" in head.lower()):
        return MeshKind.STL
    if _OBJ_LINE.match(first) and is_text(content):
        return MeshKind.OBJ
    if _OTHER_LINE.match(first) and is_text(content):
        return None
    return {f".{kind.name.lower()}": kind for kind in MeshKind}.get(path.suffix.lower())


def _finished(path: Path, part: _Part) -> TSurf:
    vertices, triangles = floats(part.vertices, -1, 3), ints(part.triangles, -1, 3)
    unfit = triangles[(triangles < 0) | (triangles >= len(vertices))]
    if len(unfit):
        raise InputError(
            f"{path}: a face has the vertex {unfit[0]}, but there are {len(vertices)}, counted from 0; "
            "export it again."
        )
    return TSurf(Surface(part.name or path.stem, vertices, triangles, file=path), None, bool(part.name))


def _loaded(content: bytes, kind: MeshKind, **options: bool) -> dict[str, Any]:
    """Return the meshes that trimesh finds, by name: as they stand, without textures."""
    import trimesh

    logging.getLogger("trimesh").addHandler(_SILENT)
    options |= {"process": False, "skip_materials": True}
    scene = trimesh.load_scene(io.BytesIO(content), file_type=kind.name.lower(), **options)
    return {name: mesh for name, mesh in scene.geometry.items() if hasattr(mesh, "faces")}


def _obj(path: Path, content: bytes) -> list[_Part]:
    """Read an OBJ file: its objects (o), in a file without any its groups (g).

    trimesh counts negative indices from the end of the file instead of from the face, takes 0 for 1, does not
    see lines that begin with blanks or have tabs, and copies vertices that have several normals or textures.
    So it is given vertices and faces alone, with plain indices.
    """
    vertices, faces = _obj_lines(decoded(content, path), path)
    lines = [f"v {row}" for row in vertices]
    for k, corners in enumerate(faces.values()):
        lines += [f"o {k}", *(f"f {row}" for row in corners)]
    options = {"split_objects": True, "group_material": False, "maintain_order": len(faces) == 1}
    meshes = _loaded("\n".join(lines).encode(), MeshKind.OBJ, **options)
    return [_Part(name, meshes[str(k)].vertices, meshes[str(k)].faces) for k, (_, name) in enumerate(faces)]


def _obj_lines(text: str, path: Path) -> tuple[list[str], dict[tuple[int, str], list[str]]]:
    """Return the coordinates of an OBJ file and, for each object or group, the plain indices of its faces."""
    by_object = re.search(r"^[ \t]*o[ \t]+\S", text, re.MULTILINE) is not None
    vertices: list[str] = []
    faces: dict[tuple[int, str], list[tuple[int, list[int]]]] = {}
    part = (0, "")
    for number, line in _continued(text):
        key, *words = line.partition("#")[0].split() or [""]
        if key == "v":
            if len(words) < 3:
                raise InputError(
                    f"{path}, line {number}: a vertex has {len(words)} numbers, not 3; correct it."
                )
            vertices.append(" ".join(words[:3]))
        elif key == "f":
            faces.setdefault(part, []).append((number, _corners(words, len(vertices), path, number)))
        elif key == ("o" if by_object else "g"):
            # The name is all that follows. A group goes on where its name comes again, an object does not.
            part = (number if by_object else 0, line.strip()[1:].strip())
    for number, corners in (face for group in faces.values() for face in group):
        if max(corners) > len(vertices):
            raise InputError(
                f"{path}, line {number}: a face names vertex {max(corners)} of {len(vertices)}; export it "
                "again."
            )
    return vertices, {
        key: [" ".join(map(str, corners)) for _, corners in group] for key, group in faces.items()
    }


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


def _corners(words: list[str], count: int, path: Path, number: int) -> list[int]:
    """Return the vertices of a face, counted from 1; ``count`` vertices stand before it."""
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
    return corners


def _ply(path: Path, content: bytes) -> list[_Part]:
    """Read a PLY file.

    trimesh says nothing of rows that are missing at the end of an ASCII file, or of corners that are missing
    in a row, and takes all polygons of a binary file for ones with as many corners as the first.
    """
    end = re.search(rb"^end_header[ \t]*\r?\n", content, re.MULTILINE)
    if end is None:
        raise InputError(f"{path} has no line end_header, so the file is cut short; export it again.")
    header = [line.split() for line in decoded(content[: end.start()], path).splitlines()]
    is_ascii = any(words[:2] == ["format", "ascii"] for words in header)
    body = content[end.end() :]
    if is_ascii:
        # The digits are there, so they count, also where the header speaks of 32-bit numbers.
        header = [_doubled(words) for words in header]
        rows = [line for line in body.splitlines() if line.strip()]
        body = b"\n".join(rows)
        if _ends_early(header, rows):
            raise InputError(f"{path}: its last row is too short, so the file is cut short; export it again.")
    known = ("ply", "format", "element", "property")
    head = "\n".join(" ".join(words) for words in header if words and words[0] in known)
    try:
        meshes = _loaded(f"{head}\nend_header\n".encode() + body, MeshKind.PLY, fix_texture=False)
    except ValueError as error:
        if is_ascii:
            raise
        raise InputError(f"{path} cannot be read: it is cut short or damaged, or {_MIXED}.") from error
    for mesh in meshes.values():
        _reject_ply_rows(path, mesh.metadata["_ply_raw"])
    return [_Part("", mesh.vertices, mesh.faces) for mesh in meshes.values()]


def _ends_early(header: list[list[str]], rows: list[bytes]) -> bool:
    """Return whether the last row of an ASCII file is that of a face and lacks corners."""
    count = next(int(words[2]) for words in reversed(header) if words[:1] == ["element"])
    words = rows[-1].split() if rows and count else []
    return header[-1][:2] == ["property", "list"] and bool(words) and len(words) <= int(words[0])


def _doubled(words: list[str]) -> list[str]:
    is_float = words[:1] == ["property"] and len(words) == 3 and words[1] in ("float", "float32")
    return ["property", "double", words[2]] if is_float else words


def _reject_ply_rows(path: Path, elements: dict[str, Any]) -> None:
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


def _stl(path: Path, content: bytes) -> list[_Part]:
    """Read an STL file: each solid of an ASCII file is a surface.

    trimesh passes over a solid without an end, and takes words for keywords in the names of solids. So solids
    are given to it under numbers, and what it has read is counted.
    """
    names = [""]
    facets: int | None = None
    if not _is_binary_stl(content):
        if not is_text(content):
            count = struct.unpack_from("<I", content.ljust(_BINARY_STL_HEAD, b"\0"), 80)[0]
            there = max(0, len(content) - _BINARY_STL_HEAD) // _BINARY_STL_TRIANGLE
            raise InputError(
                f"{path} states {count} triangles but has room for {there}, so the STL is damaged; export it "
                "again."
            )
        text, names = _numbered_solids(decoded(content, path), path)
        facets, content = len(re.findall(r"^\s*facet\b", text, re.MULTILINE | re.IGNORECASE)), text.encode()
    meshes = list(_loaded(content, MeshKind.STL).values())
    if facets is not None and facets != sum(len(mesh.faces) for mesh in meshes):
        raise InputError(f"{path}: some facet has not three vertices of three numbers; export it again.")
    numbers = [0 if facets is None else int(mesh.metadata["name"]) for mesh in meshes]
    return [
        _Part(names[k], *_merged(floats(mesh.vertices), ints(mesh.faces)))
        for k, mesh in zip(numbers, meshes, strict=True)
    ]


def _is_binary_stl(content: bytes) -> bool:
    if len(content) < _BINARY_STL_HEAD:
        return False
    count: int = struct.unpack_from("<I", content, 80)[0]
    return len(content) == _BINARY_STL_HEAD + _BINARY_STL_TRIANGLE * count


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


def _merged(vertices: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray]:
    """Return the surface with vertices equal to the bit (0 and -0 count as one) merged into the first."""
    # Zero is added, so that -0 becomes 0; the view compares bits, so that one NaN is one vertex.
    rows = np.ascontiguousarray(vertices + 0.0).view(np.int64)
    _, first, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    kept = np.sort(first)
    index = np.searchsorted(kept, first[inverse.reshape(-1)])
    return floats(vertices[kept], -1, 3), ints(index[triangles], -1, 3)


def _vtp(path: Path, content: bytes) -> list[_Part]:
    """Read a VTP file through VTK, with its numbers as wide as they are there.

    VTK says what is wrong on the terminal and gives what it has; here that is an error. It does not look at
    the indices of polygons, which :func:`read_meshes` does.
    """
    import pyvista
    from vtkmodules.vtkCommonCore import vtkLogger

    most = max(map(int, _VTP_COUNT.findall(content)), default=0)
    if most > _MOST_PER_BYTE * len(content):
        raise InputError(f"{path} states {most} elements, more than it has room for; export it again.")
    caught = pyvista.VtkErrorCatcher(send_to_logging=False)
    cutoff = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        with caught:
            reader = pyvista.XMLPolyDataReader(str(path)).reader
            reader.Update()
            data = reader.GetOutput()
    finally:
        vtkLogger.SetStderrVerbosity(cutoff)
    # VTK writes ranges of arrays that hold NaN so that it cannot read them; nothing here asks for ranges.
    errors = [e for e in caught.events if e.kind == "ERROR" and "InformationKey" not in e.alert]
    if errors:
        raise ValueError(errors[0].alert)
    if data.GetStrips().GetNumberOfCells():
        raise InputError(f"{path} holds triangle strips, which are not read; export it as triangles.")
    if not data.GetPolys().GetNumberOfCells():
        return []
    cells = data.GetPolys()
    corners = ints(pyvista.convert_array(cells.GetConnectivityArray()))
    offsets = ints(pyvista.convert_array(cells.GetOffsetsArray()))
    if np.diff(offsets).min() < 3:
        raise InputError(f"{path}: a face has fewer than three corners; export it again.")
    vertices = floats(pyvista.convert_array(data.GetPoints().GetData()), -1, 3)
    return [_Part("", vertices, corners[_fans(offsets)])]


def _fans(offsets: IntArray) -> IntArray:
    """Return the places of the corners of triangles, shape (m, 3), that fan out from each polygon's first.

    Polygon k has the places ``offsets[k]`` up to ``offsets[k + 1]``.

    >>> _fans(ints([0, 3, 7])).tolist()
    [[0, 1, 2], [3, 4, 5], [3, 5, 6]]
    """
    counts = np.diff(offsets) - 2
    first = np.repeat(offsets[:-1], counts)
    step = np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    return ints(np.stack([first, first + step + 1, first + step + 2], axis=1), -1, 3)
