"""The exact common refinement of surfaces (paper Sect. 3.2, condition 1), by exact arithmetic of CGAL."""

from __future__ import annotations

from collections.abc import Sequence

import igl.copyleft.cgal
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.complexes import Complex
from graben.proximity import box_pairs, boxes, boxes_over
from graben.surface import Surface

#: Intersections that one triangle may have; above it the library would drop the triangle silently.
_CUTOFF = 1_000_000
#: Heights over a plane below this share of what they are sums of may be rounding: a hundred times more.
_ROUNDING = 1e-12
#: Coordinates nearer to 0 are 0: exact arithmetic on numbers such as 1e-308 does not come to an end.
_NOTHING = 1e-100


def refined(surfaces: Sequence[Surface]) -> Complex:
    """Return the exact common refinement of surfaces, with shared vertices shared by index.

    Only triangles that may meet one of another surface go through exact arithmetic; all others are kept as
    they are. Vertices equal to the bit become one.

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
        asked, corners = np.unique(triangles[near], return_inverse=True)
        new, faces, _, birth, unique = igl.copyleft.cgal.remesh_self_intersections(
            np.ascontiguousarray(vertices[asked]),
            np.ascontiguousarray(corners.reshape(-1, 3), dtype=np.int64),
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
    """Return which triangles may meet one of another surface, shape (m,); all others certainly do not.

    Their bounding boxes meet, and neither lies on one side of the plane of the other.
    """
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
        second = second[boxes_over(lows[b][second], highs[b][second], lows[a][first], highs[a][first])]
        first = first[boxes_over(lows[a][first], highs[a][first], lows[b][second], highs[b][second])]
        pairs = box_pairs(lows[a][first], highs[a][first], lows[b][second], highs[b][second])
        one, two = rows[a][first[pairs[:, 0]]], rows[b][second[pairs[:, 1]]]
        apart = _beside(vertices, triangles[one], triangles[two])
        apart |= _beside(vertices, triangles[two], triangles[one])
        near[one[~apart]] = True
        near[two[~apart]] = True
    return near


def _beside(vertices: FloatArray, planes: IntArray, triangles: IntArray) -> BoolArray:
    """Return which triangles (p, 3) certainly lie on one side of the plane of another each, (p, 3)."""
    a, b, c = (vertices[planes[:, k]] for k in range(3))
    u, v = b - a, c - a
    normal = np.cross(u, v)
    away = [vertices[triangles[:, k]] - a for k in range(3)]
    height = np.stack([(w * normal).sum(axis=1) for w in away])
    size = np.sqrt(np.max([(w**2).sum(axis=1) for w in away], axis=0))
    unsure = _ROUNDING * np.sqrt((u**2).sum(axis=1) * (v**2).sum(axis=1)) * size
    return np.asarray((height > unsure).all(axis=0) | (height < -unsure).all(axis=0), dtype=bool)


def _welded(vertices: FloatArray, triangles: IntArray, owner: IntArray, parent: IntArray) -> Complex:
    """Merge vertices equal to the bit, leave out unused ones and the triangles that collapse."""
    used = np.zeros(len(vertices), dtype=bool)
    used[triangles] = True
    points = vertices[used] + 0.0
    # as np.unique along an axis, but with the runs that the order of a grid has
    order = np.lexsort(points.T[::-1])
    points = points[order]
    new = np.ones(len(order), dtype=bool)
    new[1:] = (points[1:] != points[:-1]).any(axis=1)
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.cumsum(new) - 1
    index = np.full(len(vertices), -1)
    index[used] = place
    faces = index[triangles]
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 0] != faces[:, 2])
    return Complex(points[new], faces[whole], owner[whole], parent[whole])


def component_labels(count: int, pairs: IntArray) -> IntArray:
    """Return the connected component of each of ``count`` items joined by ``pairs`` (p, 2), (count,)."""
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)
