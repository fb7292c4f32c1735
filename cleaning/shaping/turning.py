"""Triangles turned so that neighbours agree."""

from __future__ import annotations

from dataclasses import replace

import igl
import numpy as np

from graben.arrays import BoolArray, IntArray, ints
from graben.cleaning.shaping.fans import joints_of
from graben.surface import Surface, triangle_areas, triangle_normals

#: Share of its area by which two halves of a component may differ and count as equal: above rounding.
_EQUAL = 1e-9


def oriented(surface: Surface) -> Surface:
    """Return the surface with the triangles of each component turned one way, its larger area upwards.

    >>> mixed = Surface("F", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1]], [[0, 1, 2], [1, 2, 3]])
    >>> oriented(mixed).triangles.tolist()
    [[0, 1, 2], [3, 2, 1]]
    """
    turned, component = _agreeing(surface)
    down = np.bincount(component, triangle_normals(surface.vertices, turned)[:, 2]) < 0
    return _kept(surface, np.where(down[component][:, None], turned[:, [1, 0, 2]], turned))


def reconciled(surface: Surface) -> Surface:
    """Return the surface with the triangles of each component turned the way that most of its area faces.

    What already agrees stays as it is; of two halves that face against each other the first triangle's wins.

    >>> mixed = Surface("F", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1]], [[0, 1, 2], [1, 2, 3]])
    >>> reconciled(mixed).triangles.tolist()
    [[1, 0, 2], [1, 2, 3]]
    """
    turned, component = _agreeing(surface)
    same = same_turn(surface.triangles, turned)
    areas = triangle_areas(surface.vertices, surface.triangles)
    kept = np.bincount(component, np.where(same, areas, -areas))
    equal = np.abs(kept) <= _EQUAL * np.bincount(component, areas)
    first = np.unique(component, return_index=True)[1]
    against = np.where(equal, ~same[first], kept < 0)
    return _kept(surface, np.where(against[component][:, None], turned[:, [1, 0, 2]], turned))


def _agreeing(surface: Surface) -> tuple[IntArray, IntArray]:
    """Return triangles that agree with their neighbours, and the component of each."""
    turned, component = igl.bfs_orient(np.ascontiguousarray(surface.triangles))
    return np.asarray(turned, dtype=np.int64), np.asarray(component, dtype=np.int64).ravel()


def _kept(surface: Surface, turned: IntArray) -> Surface:
    """Return the surface with the triangles that differ from its own as cycles taken over."""
    same = same_turn(surface.triangles, turned)
    if same.all():
        return surface
    return replace(surface, triangles=ints(np.where(same[:, None], surface.triangles, turned)))


def same_turn(triangles: IntArray, others: IntArray) -> BoolArray:
    """Return which triangles turn as others of the same vertices do, shape (m,)."""
    return np.asarray((_cyclic(triangles) == _cyclic(others)).all(axis=1), dtype=np.bool_)


def _cyclic(triangles: IntArray) -> IntArray:
    """Return the triangles turned so that the least index comes first."""
    start = triangles.argmin(axis=1)[:, None]
    return np.asarray(np.take_along_axis(triangles, (start + np.arange(3)) % 3, axis=1), dtype=np.int64)


def disagreeing(surface: Surface) -> int:
    """Return how many edges have two triangles that face different ways.

    >>> disagreeing(Surface("F", [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1]], [[0, 1, 2], [1, 2, 3]]))
    1
    """
    t = surface.triangles.ravel()
    first, second = joints_of(surface.triangles).T
    starts = [t[side // 3 * 3 + (side % 3 + 1) % 3] for side in (first, second)]
    return int((starts[0] == starts[1]).sum())
