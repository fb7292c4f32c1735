"""VTK files of unstructured grids (.vtu): several surfaces in one file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from graben.formats.tsurf import Sign
from graben.formats.tsurf_writer import in_convention
from graben.surface import Surface


def write_vtu(path: Path, surfaces: Sequence[Surface], *, z: Sign = "elevation") -> None:
    """Write the triangles of surfaces as the cells of one grid.

    The cell array ``surface`` is the place of a triangle's surface in the field array ``names``. Vertices
    stay apart where surfaces meet.

    Parameters
    ----------
    path : Path
        The file, ending in ``.vtu``.
    surfaces : sequence of Surface
        Elevations, triangles that name vertices; written in the convention of ``z``.
    z : "elevation" or "depth"
        How the file counts z.
    """
    import pyvista
    from vtkmodules.vtkCommonCore import vtkStringArray

    starts = np.cumsum([0, *(len(s.vertices) for s in surfaces)])[:-1]
    points = [np.zeros((0, 3)), *(in_convention(s.vertices, z) for s in surfaces)]
    triangles = [s.triangles + start for s, start in zip(surfaces, starts, strict=True)]
    cells = np.concatenate([np.zeros((0, 3), dtype=np.int64), *triangles])
    mesh = pyvista.UnstructuredGrid({pyvista.CellType.TRIANGLE: cells}, np.concatenate(points))
    mesh.cell_data["surface"] = np.repeat(np.arange(len(surfaces)), [len(s.triangles) for s in surfaces])
    # pyvista itself takes no names beyond ASCII.
    names = vtkStringArray()
    names.SetName("names")
    for surface in surfaces:
        names.InsertNextValue(surface.name)
    mesh.GetFieldData().AddArray(names)
    mesh.save(str(path))
