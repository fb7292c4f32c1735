"""Triangulated surfaces from mesh files: OBJ, PLY, STL and VTP; ``docs/formats.md`` says what is read how."""

from __future__ import annotations

import warnings
from pathlib import Path

from graben.arrays import floats, ints
from graben.errors import InputError
from graben.formats.kinds import MESHES, Kind, kind_of
from graben.formats.obj import read_obj
from graben.formats.parts import Part
from graben.formats.ply import read_ply
from graben.formats.stl import read_stl
from graben.formats.text import load_bytes
from graben.formats.tsurf import TSurf, read_tsurf
from graben.formats.vtk_reader import read_vtp
from graben.surface import Surface

_READERS = {Kind.OBJ: read_obj, Kind.PLY: read_ply, Kind.STL: read_stl, Kind.VTP: read_vtp}


def read_surfaces(path: Path, kind: Kind | None = None) -> list[TSurf]:
    """Read every surface of a GOCAD TSurf or mesh file; ``kind`` saves looking for it.

    Raises
    ------
    InputError
        As of :func:`read_meshes` and :func:`graben.formats.tsurf.read_tsurf`.
    """
    return read_tsurf(path) if (kind or kind_of(path)) is Kind.TSURF else read_meshes(path, kind)


def read_meshes(path: Path, kind: Kind | None = None) -> list[TSurf]:
    """Read every surface of an OBJ, PLY, STL or VTP file.

    Polygons become fans of triangles from their first corner. Coordinates that are not finite are kept: the
    check ``finite`` reports them.

    Parameters
    ----------
    path : Path
        The file.
    kind : Kind, optional
        What it is, where that is known already.

    Returns
    -------
    list of TSurf
        In the order of the file, without a sign of z; lines of an OBJ alone. Vertices keep the order of the
        file, those that no triangle uses included where the file holds one surface; of several each has those
        that it uses. Of an STL, vertices equal to the bit are one, in the place of the first.

    Raises
    ------
    InputError
        When the file is no mesh file, holds no triangle, is cut short or damaged, or a face names no vertex.
    """
    kind = kind or kind_of(path)
    if kind not in MESHES:
        raise InputError(f"{path} is no OBJ, PLY, STL or VTP file; give one of these.")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            # Before version 2.4, numpy stops at a word that is no number with no more than this warning.
            warnings.filterwarnings("error", "string or file could not be read", DeprecationWarning)
            parts = _READERS[kind](path, load_bytes(path))
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


def _finished(path: Path, part: Part) -> TSurf:
    vertices, triangles = floats(part.vertices, -1, 3), ints(part.triangles, -1, 3)
    unfit = triangles[(triangles < 0) | (triangles >= len(vertices))]
    if len(unfit):
        raise InputError(
            f"{path}: a face has the vertex {unfit[0]}, but there are {len(vertices)}, counted from 0; "
            "export it again."
        )
    surface = Surface(part.name or path.stem, vertices, triangles, part.lines, path)
    return TSurf(surface, None, bool(part.name))
