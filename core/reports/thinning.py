"""Large horizons with fewer triangles, for pictures that could not show more."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
import triangle
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from graben.arrays import BoolArray, FloatArray, IntArray, ints
from graben.modeling.results import HorizonResult
from graben.surface import boundary_edges, edge_table

#: Meshes of fewer triangles are drawn as they are.
MOST_DRAWN = 200_000
#: Nodes of a thinned horizon stand this share of the longer side of what is shown apart: 3 dots of a map.
_APART = 1.0 / 300.0
#: Rows of triangles along the boundary, lips included, that stay.
_ROWS = 2
#: What the whole of a horizon came to: the map and the 3D view ask for the same.
_known: WeakKeyDictionary[HorizonResult, tuple[IntArray, float]] = WeakKeyDictionary()


def drawn(result: HorizonResult, triangles: IntArray) -> tuple[IntArray, float]:
    """Return triangles of a horizon (m, 3), thinned where they are too many to be seen.

    Parameters
    ----------
    result : HorizonResult
        The horizon.
    triangles : (m, 3) array
        Those of its triangles that are shown.

    Returns
    -------
    triangles : (k, 3) array
        Of the same nodes.
    spacing : float
        About how far apart nodes are now away from the boundary, model units; 0 where nothing was thinned.
    """
    if len(triangles) <= MOST_DRAWN:
        return triangles, 0.0
    whole = triangles is result.surface.triangles
    if whole and result in _known:
        return _known[result]
    spacing = _APART * float(np.ptp(result.first[among(triangles, len(result.first)), :2], axis=0).max())
    thinned = coarsened(result.first[:, :2], triangles, spacing)
    found = thinned, spacing if len(thinned) < len(triangles) else 0.0
    if whole:
        _known[result] = found
    return found


def among(triangles: IntArray, count: int) -> BoolArray:
    """Return which of ``count`` nodes are corners of triangles (m, 3); a sort takes ten times as long."""
    corner = np.zeros(count, dtype=bool)
    corner[triangles] = True
    return corner


def coarsened(plan: FloatArray, triangles: IntArray, spacing: float) -> IntArray:
    """Return a triangulation that covers the same part of the plan with fewer triangles, (k, 3).

    The boundary and two rows of triangles along it stay. The rest is a Delaunay triangulation of one node in
    each square of a raster.

    Parameters
    ----------
    plan : (n, 2) array
        Where the triangles cover the plan once.
    triangles : (m, 3) array
        Counter-clockwise.
    spacing : float
        Side of the squares, model units.
    """
    rest = _beyond(triangles, len(plan))
    if not rest.any():
        return triangles
    rim = boundary_edges(triangles[rest])
    nodes = np.unique(rim)
    inner = among(triangles[rest], len(plan))
    inner[nodes] = False
    used = np.concatenate([nodes, _one_in_each(plan, np.flatnonzero(inner), spacing)])
    index = np.full(len(plan), -1)
    index[used] = np.arange(len(used))
    points = plan[used] - plan[used].mean(axis=0)
    made = triangle.triangulate({"vertices": points, "segments": index[rim].astype(np.int32)}, "p")
    if len(made["vertices"]) != len(points):
        return triangles  # it does not cover the plan once
    new = np.asarray(made["triangles"], dtype=np.int64)
    new = new[_left_of(new, index[rim])]
    return ints(np.concatenate([triangles[~rest], used[new]]), -1, 3)


def _beyond(triangles: IntArray, count: int) -> BoolArray:
    """Return which triangles are not among the rows along the boundary, (m,)."""
    near = np.zeros(count, dtype=bool)
    near[boundary_edges(triangles)] = True
    close = near[triangles].any(axis=1)
    for _ in range(_ROWS - 1):
        near[triangles[close]] = True
        close = near[triangles].any(axis=1)
    return np.asarray(~close, dtype=bool)


def _one_in_each(plan: FloatArray, nodes: IntArray, spacing: float) -> IntArray:
    """Return of some nodes the one nearest to the middle of each square of a raster, ascending."""
    place = (plan[nodes] - plan[nodes].min(axis=0, initial=np.inf)) / spacing
    square = np.floor(place).astype(np.int64)
    off = ((place - square - 0.5) ** 2).sum(axis=1)
    key = square[:, 0] * (square[:, 1].max(initial=0) + 1) + square[:, 1]
    order = np.lexsort((off, key))
    first = np.ones(len(order), dtype=bool)
    first[1:] = key[order[1:]] != key[order[:-1]]
    return np.sort(nodes[order[first]])


def _left_of(triangles: IntArray, rim: IntArray) -> BoolArray:
    """Return which triangles (m, 3) lie on the left of directed edges (b, 2) that close around them."""
    edges, sides = edge_table(triangles)
    base = int(triangles.max()) + 1
    keys = edges[:, 0] * base + edges[:, 1]
    fence = np.zeros(len(edges), dtype=bool)
    fence[np.searchsorted(keys, rim.min(axis=1) * base + rim.max(axis=1))] = True
    m = len(triangles)
    t, k = np.nonzero(~fence[sides])
    graph = coo_array((np.ones(len(t)), (t, m + sides[t, k])), shape=(m + len(edges), m + len(edges)))
    part = connected_components(graph, directed=False)[1][:m]
    t, k = np.nonzero(fence[sides])
    way = triangles[t, (k + 1) % 3] * base + triangles[t, (k + 2) % 3]
    inside = np.zeros(int(part.max()) + 1, dtype=bool)
    inside[part[t[np.isin(way, rim[:, 0] * base + rim[:, 1])]]] = True
    return np.asarray(inside[part], dtype=bool)
