"""VTK files of unstructured grids (.vtu): several surfaces in one file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from graben.formats.tsurf import Sign
from graben.formats.tsurf_writer import in_convention
from graben.formats.vtk_fields import add_fields
from graben.surface import Surface


def write_vtu(
    path: Path, surfaces: Sequence[Surface], *, z: Sign = "elevation", unit: str = "", crs: str | None = None
) -> None:
    """Write the triangles of surfaces as the cells of one grid.

    The cell array ``surface`` is the place of a triangle's surface in the field array ``names``; others say
    how z counts, the unit and the coordinate system. Vertices stay apart where surfaces meet.

    Parameters
    ----------
    path : Path
        The file, ending in ``.vtu``.
    surfaces : sequence of Surface
        Elevations, triangles that name vertices; written in the convention of ``z``.
    z : "elevation" or "depth"
        How the file counts z.
    unit, crs : str
        Unit of lengths and name of the coordinate system, where there are any.
    """
    import pyvista

    starts = np.cumsum([0, *(len(s.vertices) for s in surfaces)])[:-1]
    points = [np.zeros((0, 3)), *(in_convention(s.vertices, z) for s in surfaces)]
    triangles = [s.triangles + start for s, start in zip(surfaces, starts, strict=True)]
    cells = np.concatenate([np.zeros((0, 3), dtype=np.int64), *triangles])
    mesh = pyvista.UnstructuredGrid({pyvista.CellType.TRIANGLE: cells}, np.concatenate(points))
    mesh.cell_data["surface"] = np.repeat(np.arange(len(surfaces)), [len(s.triangles) for s in surfaces])
    add_fields(mesh, [s.name for s in surfaces], z, unit, {} if crs is None else {"crs": crs})
    mesh.save(str(path))
