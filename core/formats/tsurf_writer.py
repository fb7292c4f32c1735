"""GOCAD TSurf files out: one plain dialect, every number with as many digits as it has."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graben.arrays import FloatArray
from graben.formats.numbers import blocks, rows_of_text
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
    with path.open("wb") as file:
        for surface in surfaces:
            # A line holds the name: whatever would end it, or make the file binary, becomes a space.
            name = " ".join("".join(c if c.isprintable() else " " for c in surface.name).split())
            head = ["GOCAD TSurf 1", "HEADER {", f"name:{name}", "}", *frame]
            head += [f"GEOLOGICAL_FEATURE {name}", f"GEOLOGICAL_TYPE {feature}"]
            head += _property_header(list(values)) if values else []
            file.write("\n".join([*head, "TFACE", ""]).encode())
            for text in _mesh_text(surface, z, values):
                file.write(text)
            file.write(b"END\n")


def _mesh_text(surface: Surface, z: Sign, properties: Mapping[str, NDArray[Any]]) -> Iterator[bytes]:
    """Yield the lines of vertices and triangles, block by block."""
    line = b"PVRTX %d %b\n" if properties else b"VRTX %d %b\n"
    vertices = in_convention(surface.vertices, z)
    for block in blocks(len(vertices)):
        columns = [vertices[block], *(values[block, None] for values in properties.values())]
        texts = map(b" ".join, zip(*(rows_of_text(c) for c in _joined(columns)), strict=True))
        yield b"".join(map(line.__mod__, enumerate(texts, start=block.start + 1)))
    for block in blocks(len(surface.triangles)):
        yield b"TRGL " + b"\nTRGL ".join(rows_of_text(surface.triangles[block] + 1)) + b"\n"


def _joined(columns: Sequence[NDArray[Any]]) -> list[NDArray[Any]]:
    """Return columns (n, k) with those of one kind of number that follow each other in one array."""
    runs = groupby(columns, key=lambda column: column.dtype)
    return [np.concatenate(list(run), axis=1) for _, run in runs]


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
