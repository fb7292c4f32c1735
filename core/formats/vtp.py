"""VTK polygon files (.vtp)."""

from __future__ import annotations

from collections.abc import Mapping
from errno import EIO
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from graben.formats.tsurf import Sign
from graben.formats.tsurf_writer import in_convention
from graben.formats.vtk_fields import add_fields
from graben.surface import Surface

#: Of zlib: takes half the time of the usual level and gives files a tenth larger.
_COMPRESSION = 1


def write_vtp(
    path: Path,
    surface: Surface,
    *,
    z: Sign = "elevation",
    arrays: Mapping[str, ArrayLike] | None = None,
    unit: str = "",
    notes: Mapping[str, str] | None = None,
) -> None:
    """Write a surface with named values at its vertices.

    Parameters
    ----------
    path : Path
        The file, ending in ``.vtp``.
    surface : Surface
        Elevations; written in the convention of ``z``.
    z : "elevation" or "depth"
        How the file counts z.
    arrays : mapping of str to (n,) array, optional
        Point arrays.
    unit : str
        Of lengths, where there is one.
    notes : mapping of str to str, optional
        Further words for the field data, where name, sign of z and unit stand.
    """
    mesh = surface.with_vertices(in_convention(surface.vertices, z)).to_pyvista()
    for name, values in (arrays or {}).items():
        mesh.point_data[name] = np.asarray(values)
    add_fields(mesh, [surface.name], z, unit, notes or {})
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    writer = vtkXMLPolyDataWriter()
    writer.SetFileName(str(path))
    writer.SetInputData(mesh)
    writer.SetCompressionLevel(_COMPRESSION)
    if not writer.Write():
        raise OSError(EIO, "VTK could not write the file", str(path))
