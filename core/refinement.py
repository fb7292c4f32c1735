"""The exact common refinement of surfaces (paper Sect. 3.2, condition 1), by exact arithmetic of CGAL."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import igl.copyleft.cgal
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.beside import beside
from graben.complexes import Complex
from graben.proximity import box_pairs, boxes, boxes_over
from graben.surface import Surface

#: Intersections that one triangle may have; above it the library would drop the triangle silently.
_CUTOFF = 1_000_000
#: Triangles from which on two cores share the exact arithmetic, which takes about a millisecond for each.
_WORTH = 2000
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
    pairs = meeting_triangles(vertices, triangles, owner)
    if len(pairs):
        first, *rest = _halves(vertices, triangles, pairs)
        later = [beside(partial(_exact, vertices, triangles, half)) for half in rest]
        made = [_exact(vertices, triangles, first), *(value() for value in later)]
        near = np.zeros(len(triangles), dtype=bool)
        near[pairs] = True
        starts = np.cumsum([0, *(len(new) for new, _, _ in made)])
        faces = np.concatenate([f + start for (_, f, _), start in zip(made, starts, strict=False)])
        source = np.concatenate([source for _, _, source in made])
        triangles = np.concatenate([triangles[~near] + starts[-1], faces])
        owner = np.concatenate([owner[~near], owner[source]])
        parent = np.concatenate([parent[~near], parent[source]])
        vertices = np.concatenate([*(new for new, _, _ in made), vertices])
    return _welded(vertices, triangles, owner, parent)


def _exact(
    vertices: FloatArray, triangles: IntArray, chosen: IntArray
) -> tuple[FloatArray, IntArray, IntArray]:
    """Return vertices (n, 3) and triangles (m, 3) of the refinement of some, and of which each is a part."""
    asked, corners = np.unique(triangles[chosen], return_inverse=True)
    new, faces, _, birth, unique = igl.copyleft.cgal.remesh_self_intersections(
        np.ascontiguousarray(vertices[asked]),
        np.ascontiguousarray(corners.reshape(-1, 3), dtype=np.int64),
        False,
        False,
        False,
        True,
        _CUTOFF,
    )
    return new, unique[faces], chosen[birth]


def _halves(vertices: FloatArray, triangles: IntArray, pairs: IntArray) -> list[IntArray]:
    """Return the triangles of pairs (p, 2) in two parts that do not meet, about as large; in one if few.

    What may meet stays together: pairs that share a triangle, and clusters of such whose boxes meet, since
    a surface may cross itself there.
    """
    near, index = np.unique(pairs, return_inverse=True)
    if len(near) < _WORTH:
        return [near]
    cluster = component_labels(len(near), index.reshape(-1, 2))
    low, high = boxes(vertices, triangles[near])
    order = np.argsort(cluster, kind="stable")
    starts = np.append(0, np.cumsum(np.bincount(cluster))[:-1])
    low, high = np.minimum.reduceat(low[order], starts), np.maximum.reduceat(high[order], starts)
    group = component_labels(len(starts), box_pairs(low, high, low, high))[cluster]
    sizes = np.bincount(group)
    second = np.zeros(len(sizes), dtype=bool)
    for largest in np.argsort(-sizes, kind="stable"):
        second[largest] = sizes[second].sum() < sizes[~second].sum() - sizes[largest]
    parts = [near[~second[group]], near[second[group]]]
    return [part for part in parts if len(part)]


def meeting_triangles(vertices: FloatArray, triangles: IntArray, owner: IntArray) -> IntArray:
    """Return the pairs of triangles of two surfaces that may meet, (p, 2); all others certainly do not.

    Their bounding boxes meet, and neither lies on one side of the plane of the other.
    """
    found = [np.zeros((0, 2), dtype=np.int64)]
    if len(np.unique(owner)) < 2:
        return found[0]
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
        found.append(np.stack([one, two], axis=1)[~apart])
    return np.concatenate(found)


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
