"""VTK polygon files (.vtp) in, through VTK itself."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from graben.arrays import floats, ints
from graben.errors import InputError
from graben.formats.parts import Part, fans

#: Elements that a byte of a file may stand for: more than compression gives, so that a damaged count does not
#: make VTK end the process for want of memory.
_MOST_PER_BYTE = 100
_COUNT = re.compile(rb"NumberOf\w+\s*=\s*[\"']\s*(\d+)")


def read_vtp(path: Path, content: bytes) -> list[Part]:
    """Read the polygons of a VTP file, with their numbers as wide as they are there.

    VTK says what is wrong on the terminal and gives what it has; here that is an error. It does not look at
    the indices of polygons, which is left to the caller.

    Parameters
    ----------
    path : Path
        The file.
    content : bytes
        What it holds.

    Raises
    ------
    InputError
        When the file states more than it has room for, or holds strips or lines for polygons.
    ValueError
        When VTK finds an error.
    """
    import pyvista
    from vtkmodules.vtkCommonCore import vtkLogger

    most = max(map(int, _COUNT.findall(content)), default=0)
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
    polygons = data.GetPolys()
    if not polygons.GetNumberOfCells():
        return []
    corners = ints(pyvista.convert_array(polygons.GetConnectivityArray()))
    offsets = ints(pyvista.convert_array(polygons.GetOffsetsArray()))
    if np.diff(offsets).min() < 3:
        raise InputError(f"{path}: a face has fewer than three corners; export it again.")
    vertices = floats(pyvista.convert_array(data.GetPoints().GetData()), -1, 3)
    return [Part("", vertices, corners[fans(offsets)])]
