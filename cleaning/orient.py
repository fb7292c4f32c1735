"""orient: triangles turned so that neighbours agree (answers `oriented`)."""

from __future__ import annotations

from dataclasses import replace

import igl
import numpy as np

from graben.arrays import ints
from graben.cleaning.repairing import Repair, of_one_fault
from graben.surface import Surface, triangle_normals


def oriented(surface: Surface) -> Surface:
    """Return the surface with the triangles of each component turned one way, its larger area upwards.

    >>> mixed = Surface("F", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1]], [[0, 1, 2], [1, 2, 3]])
    >>> oriented(mixed).triangles.tolist()
    [[0, 1, 2], [3, 2, 1]]
    """
    turned, component = igl.bfs_orient(np.ascontiguousarray(surface.triangles))
    up = triangle_normals(surface.vertices, turned)[:, 2]
    down = np.bincount(component, up) < 0
    turned = np.where(down[component][:, None], turned[:, [1, 0, 2]], turned)
    same = _cyclic(turned) == _cyclic(surface.triangles)
    return replace(surface, triangles=ints(np.where(same.all(axis=1)[:, None], surface.triangles, turned)))


def _cyclic(triangles: np.ndarray) -> np.ndarray:
    """Return the triangles turned so that the least index comes first."""
    start = triangles.argmin(axis=1)[:, None]
    return np.take_along_axis(triangles, (start + np.arange(3)) % 3, axis=1)


REPAIR = Repair(
    "orient",
    ("oriented",),
    "turns triangles so that neighbours agree",
    of_one_fault("oriented", oriented, "Triangles were turned so that neighbours agree."),
)
