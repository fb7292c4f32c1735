"""The exact common refinement of surfaces (paper Sect. 3.2, condition 1), by exact arithmetic of CGAL."""

from __future__ import annotations

from collections.abc import Sequence

import igl.copyleft.cgal
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.complexes import Complex
from graben.proximity import box_pairs, boxes
from graben.surface import Surface

#: Intersections that one triangle may have; above it the library would drop the triangle silently.
_CUTOFF = 1_000_000
#: Coordinates nearer to 0 are 0: exact arithmetic on numbers such as 1e-308 does not come to an end.
_NOTHING = 1e-100


def refined(surfaces: Sequence[Surface]) -> Complex:
    """Return the exact common refinement of surfaces, with shared vertices shared by index.

    Only triangles whose bounding boxes meet a box of another surface go through exact arithmetic; all
    others are kept as they are. Vertices equal to the bit become one.

    Parameters
    ----------
    surfaces : sequence of Surface
        Finite coordinates and indices in range.

    Returns
    -------
    Complex
        ``owner`` is the position in ``surfaces``, ``parent`` the triangle there.
    """
    vertices = np.concatenate([s.vertices for s in surfaces] or [np.zeros((0, 3))])
    vertices = np.where(np.abs(vertices) < _NOTHING, 0.0, vertices)
    starts = np.cumsum([0] + [len(s.vertices) for s in surfaces])
    triangles = np.concatenate(
        [s.triangles + start for s, start in zip(surfaces, starts, strict=False)] or [np.zeros((0, 3), int)]
    )
    owner = np.repeat(np.arange(len(surfaces)), [len(s.triangles) for s in surfaces])
    parent = np.concatenate([np.arange(len(s.triangles)) for s in surfaces] or [np.zeros(0, int)])
    near = meeting_triangles(vertices, triangles, owner)
    if near.any():
        new, faces, _, birth, unique = igl.copyleft.cgal.remesh_self_intersections(
            np.ascontiguousarray(vertices),
            np.ascontiguousarray(triangles[near], dtype=np.int64),
            False,
            False,
            False,
            True,
            _CUTOFF,
        )
        faces = unique[faces]
        source = np.flatnonzero(near)[birth]
        triangles = np.concatenate([triangles[~near] + len(new), faces])
        owner = np.concatenate([owner[~near], owner[source]])
        parent = np.concatenate([parent[~near], parent[source]])
        vertices = np.concatenate([new, vertices])
    return _welded(vertices, triangles, owner, parent)


def meeting_triangles(vertices: FloatArray, triangles: IntArray, owner: IntArray) -> BoolArray:
    """Return which triangles have a bounding box that meets a box of another surface, shape (m,)."""
    near = np.zeros(len(triangles), dtype=bool)
    if len(np.unique(owner)) < 2:
        return near
    low, high = boxes(vertices, triangles)
    rows = np.split(np.argsort(owner, kind="stable"), np.cumsum(np.bincount(owner))[:-1])
    rows = [own for own in rows if len(own)]
    lows, highs = [low[own] for own in rows], [high[own] for own in rows]
    bounds_low = np.array([own.min(axis=0) for own in lows])
    bounds_high = np.array([own.max(axis=0) for own in highs])
    met = ((bounds_low[:, None] <= bounds_high) & (bounds_low <= bounds_high[:, None])).all(axis=2)
    for a, b in np.argwhere(np.triu(met, 1)).tolist():
        box_low = np.maximum(bounds_low[a], bounds_low[b])
        box_high = np.minimum(bounds_high[a], bounds_high[b])
        first, second = (
            np.flatnonzero((highs[k] >= box_low).all(axis=1) & (lows[k] <= box_high).all(axis=1))
            for k in (a, b)
        )
        pairs = box_pairs(lows[a][first], highs[a][first], lows[b][second], highs[b][second])
        near[rows[a][first[pairs[:, 0]]]] = True
        near[rows[b][second[pairs[:, 1]]]] = True
    return near


def _welded(vertices: FloatArray, triangles: IntArray, owner: IntArray, parent: IntArray) -> Complex:
    """Merge vertices equal to the bit, leave out unused ones and the triangles that collapse."""
    used, flat = np.unique(triangles, return_inverse=True)
    unique, index = np.unique(vertices[used] + 0.0, axis=0, return_inverse=True)
    faces = index.reshape(-1)[flat].reshape(-1, 3)
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 0] != faces[:, 2])
    return Complex(unique, faces[whole], owner[whole], parent[whole])


def component_labels(count: int, pairs: IntArray) -> IntArray:
    """Return the connected component of each of ``count`` items joined by ``pairs`` (p, 2), (count,)."""
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)
