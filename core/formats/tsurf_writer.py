"""GOCAD TSurf files out: one plain dialect, every number with as many digits as it has."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graben.arrays import FloatArray
from graben.formats.tsurf import Sign
from graben.surface import Surface

Feature = Literal["fault", "top"]


def write_tsurf(
    path: Path,
    surfaces: Sequence[Surface],
    *,
    z: Sign = "elevation",
    feature: Feature = "fault",
    unit: str = "m",
    crs: str | None = None,
    properties: Mapping[str, ArrayLike] | None = None,
) -> None:
    """Write surfaces as TSurf objects that read back to the bit.

    Parameters
    ----------
    path : Path
        The file.
    surfaces : sequence of Surface
        Elevations; written in the convention of ``z``.
    z : "elevation" or "depth"
        What ZPOSITIVE says.
    feature : "fault" or "top"
        GEOLOGICAL_TYPE: a fault, or the top of a layer (a horizon).
    unit : str
        Unit of the axes.
    crs : str, optional
        Name of the coordinate system.
    properties : mapping of str to (n,) array, optional
        Values at the vertices, for files of one surface.
    """
    values = {name: np.asarray(array) for name, array in (properties or {}).items()}
    frame = [
        "GOCAD_ORIGINAL_COORDINATE_SYSTEM",
        f"NAME {crs or 'Default'}",
        'AXIS_NAME "X" "Y" "Z"',
        f'AXIS_UNIT "{unit}" "{unit}" "{unit}"',
        f"ZPOSITIVE {z.capitalize()}",
        "END_ORIGINAL_COORDINATE_SYSTEM",
    ]
    parts: list[str] = []
    for surface in surfaces:
        # A line holds the name: whatever would end it, or make the file binary, becomes a space.
        name = " ".join("".join(c if c.isprintable() else " " for c in surface.name).split())
        parts += ["GOCAD TSurf 1", "HEADER {", f"name:{name}", "}", *frame]
        parts += [f"GEOLOGICAL_FEATURE {name}", f"GEOLOGICAL_TYPE {feature}"]
        parts += _mesh_lines(surface, z, values)
    path.write_text("\n".join([*parts, ""]), encoding="utf-8", newline="\n")


def _mesh_lines(surface: Surface, z: Sign, properties: Mapping[str, NDArray[Any]]) -> list[str]:
    """Return the lines from the properties to END."""
    head = _property_header(list(properties)) if properties else []
    vertices = in_convention(surface.vertices, z)
    keyword = "PVRTX" if properties else "VRTX"
    columns = [_texts(column) for column in (*vertices.T, *properties.values())]
    rows = (f"{keyword} {i} {' '.join(row)}" for i, row in enumerate(zip(*columns, strict=True), start=1))
    corners = (f"TRGL {a} {b} {c}" for a, b, c in (surface.triangles + 1).tolist())
    return [*head, "TFACE", *rows, *corners, "END"]


def _property_header(names: Sequence[str]) -> list[str]:
    """Return the lines that declare properties; readers such as OpenGeode ask for all of them."""
    n = len(names)

    def line(key: str, words: Iterable[str]) -> str:
        return f"{key} {' '.join(words)}"

    return [
        line("PROPERTIES", names),
        line("PROP_LEGAL_RANGES", ["**none** **none**"] * n),
        line("NO_DATA_VALUES", ["-99999"] * n),
        line("PROPERTY_CLASSES", names),
        line("PROPERTY_KINDS", ['"Real Number"'] * n),
        line("PROPERTY_SUBCLASSES", ["QUANTITY Float"] * n),
        line("ESIZES", ["1"] * n),
        line("UNITS", ["none"] * n),
    ]


def in_convention(points: FloatArray, z: Sign) -> FloatArray:
    """Return points, shape (n, 3), with z counted as ``z`` says instead of upwards."""
    return points if z == "elevation" else np.asarray(points * np.array([1.0, 1.0, -1.0]), dtype=np.float64)


def _texts(column: NDArray[Any]) -> list[str]:
    """Return the shortest texts that read back to the same numbers, which take at most 17 digits."""
    return [repr(value) for value in column.tolist()]
