"""The surfaces of a mesh file as they stand there, and what its readers share."""

from __future__ import annotations

import io
import logging
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from graben.arrays import IntArray, ints

#: trimesh logs what it passes over, which without a handler would go to the terminal, traceback and all.
_SILENT = logging.NullHandler()


@dataclass(frozen=True, eq=False)
class Part:
    """One surface of a mesh file; ``name`` is empty where the file has none.

    ``vertices`` (n, 3), ``triangles`` (m, 3) and, where known, the 1-based ``lines`` (m,) of the triangles.
    """

    name: str
    vertices: ArrayLike
    triangles: ArrayLike
    lines: IntArray = field(default_factory=lambda: ints([]))


def fans(offsets: IntArray) -> IntArray:
    """Return the places of the corners of triangles, shape (m, 3), that fan out from each polygon's first.

    Polygon k has the places ``offsets[k]`` up to ``offsets[k + 1]``.

    >>> fans(ints([0, 3, 7])).tolist()
    [[0, 1, 2], [3, 4, 5], [3, 5, 6]]
    """
    counts = np.diff(offsets) - 2
    first = np.repeat(offsets[:-1], counts)
    step = np.arange(len(first)) - np.repeat(np.cumsum(counts) - counts, counts)
    return ints(np.stack([first, first + step + 1, first + step + 2], axis=1), -1, 3)


def loaded(content: bytes, kind: str, **options: bool) -> dict[str, Any]:
    """Return the meshes that trimesh finds in a file of a kind, by name: as they stand, without textures."""
    import trimesh

    logging.getLogger("trimesh").addHandler(_SILENT)
    options |= {"process": False, "skip_materials": True}
    scene = trimesh.load_scene(io.BytesIO(content), file_type=kind, **options)
    return {name: mesh for name, mesh in scene.geometry.items() if hasattr(mesh, "faces")}
