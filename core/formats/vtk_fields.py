"""What VTK files have no place for but as field data: names, the sign of z, the unit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from graben.formats.tsurf import Sign

_SIGNS = {"elevation": "elevation, positive up", "depth": "depth, positive down"}


def add_fields(mesh: Any, names: Sequence[str], z: Sign, unit: str, more: Mapping[str, str]) -> None:
    """Add field arrays of text to a VTK data set: ``names``, ``z``, ``unit`` if there is one, and ``more``.

    Parameters
    ----------
    mesh : vtkDataSet
        It is changed.
    names : sequence of str
        Of the surfaces in it.
    z : "elevation" or "depth"
        How it counts z.
    unit : str
        Of lengths; "none" or nothing for a model without.
    more : mapping of str to str
        Further words by their names.
    """
    known = {"names": list(names), "z": [_SIGNS[z]]}
    known |= {"unit": [unit]} if unit not in ("", "none") else {}
    for key, texts in {**known, **{key: [text] for key, text in more.items()}}.items():
        add_text(mesh, key, *texts)


def add_text(mesh: Any, name: str, *texts: str) -> None:
    """Add a field array of texts to a VTK data set, which is changed."""
    # pyvista itself takes no names beyond ASCII.
    from vtkmodules.vtkCommonCore import vtkStringArray

    array = vtkStringArray()
    array.SetName(name)
    for text in texts:
        array.InsertNextValue(text)
    mesh.GetFieldData().AddArray(array)
