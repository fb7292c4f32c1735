"""Triangles divided at points on their sides and inside them, each in its own plane."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely
import triangle as triangle_library
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, bools
from graben.cleaning.shaping.complex_mesh import Net, Tables, expanded, taken
from graben.errors import GrabenError

#: Distance between the places at which triangles are laid out side by side, in sides of 1.
_APART = 4.0
#: Points nearer than this, over the longest side, are one.
_NOTHING = 1e-12


@dataclass(frozen=True, eq=False)
class Inserts:
    """What triangles are divided at; vertices by their index in the net.

    Parameters
    ----------
    edges, edge_vertices, edge_shares : (k,) arrays
        The edge that each vertex lies on, and its share of the way from the edge's first end.
    faces, face_vertices : (q,) arrays
        The triangle that each vertex lies in.
    segment_faces : (s,) array
        The triangle of each segment.
    segments : (s, 2) array
        The vertices that it joins.
    """

    edges: IntArray
    edge_vertices: IntArray
    edge_shares: FloatArray
    faces: IntArray
    face_vertices: IntArray
    segment_faces: IntArray
    segments: IntArray


def subdivided(net: Net, tables: Tables, inserts: Inserts, target: IntArray) -> Net:
    """Return a net with vertices merged and triangles divided; what that touches is fresh.

    Parameters
    ----------
    net : Net
        With the inserted vertices; its triangles as those of ``tables``.
    tables : Tables
        Of the net before.
    inserts : Inserts
        In terms of the edges and triangles of ``tables``.
    target : (n,) array
        The vertex that takes the place of each.

    Raises
    ------
    GrabenError
        When inserted points coincide or segments cross.
    """
    order = np.lexsort((inserts.edge_shares, inserts.edges))
    edge, inserted = inserts.edges[order], inserts.edge_vertices[order]
    starts = np.searchsorted(edge, np.arange(len(tables.edges) + 1))
    divided = np.diff(starts) > 0
    touched = bools(divided[tables.sides].any(axis=1)).copy()
    touched[inserts.faces] = touched[inserts.segment_faces] = True
    merged = target[net.triangles]
    if not touched.any():
        return _whole(net, merged, np.arange(len(merged)), (merged != net.triangles).any(axis=1))
    rows = np.flatnonzero(touched)
    loops = _outlines(net, tables, rows, (inserted, starts), target)
    new, parent = _triangulated(net, rows, loops, inserts, target)
    kept = np.flatnonzero(~touched)
    triangles = np.concatenate([merged[kept], new])
    source = np.concatenate([kept, parent])
    fresh = np.concatenate([(merged != net.triangles).any(axis=1)[kept], np.ones(len(new), dtype=bool)])
    return _whole(net, triangles, source, fresh)


def _whole(net: Net, triangles: IntArray, source: IntArray, fresh: BoolArray) -> Net:
    """Return the net of some triangles, parts of those in ``source``, without those that have collapsed."""
    a, b, c = triangles.T
    good = (a != b) & (b != c) & (c != a)
    source = source[good]
    made = taken(net, source)
    return replace(
        made, triangles=triangles[good], fresh=np.asarray(made.fresh | fresh[good], dtype=np.bool_)
    )


def _outlines(
    net: Net, tables: Tables, rows: IntArray, inserted: tuple[IntArray, IntArray], target: IntArray
) -> tuple[IntArray, IntArray]:
    """Return the outline of triangles: the row of each of its vertices, and the vertex, in their turn."""
    row, place, vertex = [], [], []
    for k in range(3):
        start = net.triangles[rows, (k + 1) % 3]
        edge = tables.sides[rows, k]
        at, found = expanded(*inserted, edge)
        forward = tables.edges[edge, 0] == start
        rank = np.arange(len(at)) - np.searchsorted(at, at)
        rank = np.where(forward[at], rank, np.bincount(at, minlength=len(rows))[at] - 1 - rank)
        row += [np.arange(len(rows)), at]
        place += [np.full(len(rows), k * 1e6), k * 1e6 + 1 + rank]
        vertex += [target[start], target[found]]
    rows_of, places, vertices = (np.concatenate(x) for x in (row, place, vertex))
    order = np.lexsort((places, rows_of))
    return rows_of[order], vertices[order]


def _triangulated(
    net: Net, rows: IntArray, loops: tuple[IntArray, IntArray], inserts: Inserts, target: IntArray
) -> tuple[IntArray, IntArray]:
    """Return the parts of triangles, by vertex, and the triangle that each is a part of.

    All are laid out side by side in one plane, so that one call triangulates them.
    """
    row, vertex = loops
    position = np.full(len(net.triangles), -1)
    position[rows] = np.arange(len(rows))
    last = np.r_[row[1:] != row[:-1], True]
    first = np.r_[True, last[:-1]]
    ahead = np.r_[vertex[1:], vertex[:1]]
    ahead[last] = vertex[first]
    rims = np.column_stack([row, vertex, ahead])[vertex != ahead]
    inner = np.column_stack([position[inserts.segment_faces], target[inserts.segments]])
    inner = inner[inner[:, 1] != inner[:, 2]]
    lines = np.concatenate([rims, inner])
    alone = np.column_stack([position[inserts.faces], target[inserts.face_vertices]])
    keys = np.concatenate([lines[:, :2], lines[:, [0, 2]], alone])
    nodes, local = np.unique(keys, axis=0, return_inverse=True)
    local = local.reshape(-1)
    ends = np.unique(np.sort(np.column_stack(np.split(local[: 2 * len(lines)], 2)), axis=1), axis=0)
    flat = _laid_out(net, rows, nodes)
    _require_sound(flat, ends)
    made = triangle_library.triangulate({"vertices": flat, "segments": ends}, "pQ")
    corners = np.asarray(made["triangles"], dtype=np.int64)
    corners = corners[(corners < len(nodes)).all(axis=1)]
    return nodes[corners, 1], rows[nodes[corners[:, 0], 0]]


def _require_sound(points: FloatArray, segments: IntArray) -> None:
    """Raise GrabenError where points coincide or segments cross: the library would end the process."""
    lines = shapely.linestrings(points[segments])
    crossing = shapely.STRtree(lines).query(lines, predicate="crosses")
    if crossing.size or len(cKDTree(points).query_pairs(_NOTHING)):
        raise GrabenError("A triangle cannot be divided: lines on it cross, or points coincide.")


def _laid_out(net: Net, rows: IntArray, nodes: IntArray) -> FloatArray:
    """Return the places of vertices in the planes of their triangles, side by side, shape (k, 2).

    Triangles turn counter-clockwise there.
    """
    a, b, c = (net.vertices[net.triangles[rows, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    sides = np.stack([b - a, c - b, a - c], axis=1)
    size = np.linalg.norm(sides, axis=2)
    along = sides[np.arange(len(rows)), size.argmax(axis=1)]
    scale = size.max(axis=1)[:, None]
    u = along / scale
    v = np.cross(across, u)
    v /= np.maximum(np.linalg.norm(v, axis=1), np.finfo(float).tiny)[:, None]
    row, vertex = nodes.T
    off = (net.vertices[vertex] - a[row]) / scale[row]
    columns = int(np.ceil(np.sqrt(len(rows))))
    corner = _APART * np.column_stack([row % columns, row // columns])
    return np.column_stack([np.einsum("ij,ij->i", off, w[row]) for w in (u, v)]) + corner
