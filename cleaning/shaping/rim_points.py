"""What the edges of a rim meet on another surface: its vertices, edges and triangles, point by point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.cleaning.shaping.complex_mesh import FREE, Net, Tables, expanded
from graben.proximity import box_pairs

#: Share of a rim's edge by which the other fault may bulge between two of its vertices that lie on it.
BULGE = 0.1
#: A vertex of the rim that comes to lie nearer to a corner or a side of the other's triangle than this share
#: of its shortest side is moved there: else a sliver would stand between them.
SNAP = 0.05
#: Sine of the angle below which two edges run along each other and do not cross.
ALONG = 1e-3
#: A vertex is led into an edge of the rim where it is this many times further from its ends than off it.
_BESIDE = 2.0
#: How a point lies on a surface.
VERTEX, EDGE, FACE = 0, 1, 2


@dataclass(frozen=True, eq=False)
class Points:
    """Points on the edges of a rim, in their order along each: what they are on the other surface.

    Parameters
    ----------
    line : (k,) array
        The rim's edge.
    share : (k,) array
        Of the way along it.
    vertex : (k,) array
        Index in the net.
    kind, index : (k,) arrays
        VERTEX, EDGE or FACE of the other, and which.
    """

    line: IntArray
    share: FloatArray
    vertex: IntArray
    kind: IntArray
    index: IntArray

    def sorted(self) -> Points:
        """Return the points by line, along it."""
        return self.some(np.lexsort((self.share, self.line)))

    def some(self, rows: IntArray | BoolArray) -> Points:
        """Return some of the points."""
        return Points(*(getattr(self, name)[rows] for name in ("line", "share", "vertex", "kind", "index")))

    def and_more(self, *more: Points) -> Points:
        """Return these points and others."""
        names = ("line", "share", "vertex", "kind", "index")
        return Points(*(np.concatenate([getattr(p, name) for p in (self, *more)]) for name in names))


def placed(
    net: Net,
    tables: Tables,
    vertices: IntArray,
    triangle: IntArray,
    place: FloatArray,
    snap: tuple[FloatArray, float],
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return what of the other surface vertices come to lie on: kind, index, and the place there.

    ``snap``: how far each may be moved along the other to a side or a corner, and at least. Not to a corner
    that a third surface has which the vertex's own does not touch yet.
    """
    corners = net.vertices[net.triangles[triangle]]
    sides = np.roll(corners, -1, axis=1) - corners
    size = np.linalg.norm(sides, axis=2)
    near = np.minimum(snap[0], np.maximum(snap[1], SNAP * size.min(axis=1)))
    rows = np.arange(len(triangle))
    kind, index, where = np.full(len(rows), FACE), triangle.copy(), place.copy()
    share = np.einsum("ijk,ijk->ij", place[:, None] - corners, sides) / size**2
    foot = corners + np.clip(share, 0, 1)[..., None] * sides
    away = np.linalg.norm(foot - place[:, None], axis=2)
    # a line of the other counts before what lies inside it: a rim beside it would leave a strip
    line = tables.held[tables.sides[triangle]][:, [2, 0, 1]] & (away <= near[:, None])
    k = np.where(line.any(axis=1), np.where(line, away, np.inf).argmin(axis=1), away.argmin(axis=1))
    hit = away[rows, k] <= near
    kind[hit], index[hit], where[hit] = EDGE, tables.sides[triangle, (k + 2) % 3][hit], foot[rows, k][hit]
    away = np.linalg.norm(corners - place[:, None], axis=2)
    on_line = (tables.kind != FREE)[net.triangles[triangle]]
    away = np.where(line.any(axis=1)[:, None] & ~on_line, np.inf, away)
    k = away.argmin(axis=1)
    hit = (away[rows, k] <= near) & ~tables.bring_together(vertices, net.triangles[triangle, k])
    kind[hit], index[hit], where[hit] = VERTEX, net.triangles[triangle, k][hit], corners[rows, k][hit]
    return kind, index, where


def ends_on(tables: Tables, lines: IntArray, vertices: IntArray, kind: IntArray, index: IntArray) -> Points:
    """Return the ends of the rim's edges that lie on the other as points on them.

    ``vertices``: those that do, ascending, with what each lies on.
    """
    ends, line = tables.edges[lines].ravel(), np.repeat(lines, 2)
    share = np.tile([0.0, 1.0], len(lines))
    on = np.isin(ends, vertices)
    at = np.searchsorted(vertices, ends[on])
    return Points(line[on], share[on], ends[on], kind[at], index[at])


def vertices_on(
    tables: Tables, net: Net, lines: IntArray, ends: Points, mine: IntArray, contact: float
) -> Points:
    """Return the other surface's vertices that lie on the inside of the rim's edges."""
    others = np.setdiff1d(np.unique(net.triangles[mine]), ends.index[ends.kind == VERTEX])
    a, b = (net.vertices[tables.edges[lines, k]] for k in (0, 1))
    p = net.vertices[others]
    reach = np.maximum(contact, SNAP * np.linalg.norm(b - a, axis=1))
    wide = reach[:, None]
    row, which = box_pairs(np.minimum(a, b) - wide, np.maximum(a, b) + wide, p, p).T
    way = b[row] - a[row]
    share = np.einsum("ij,ij->i", p[which] - a[row], way) / np.einsum("ij,ij->i", way, way)
    away = np.linalg.norm(a[row] + share[:, None] * way - p[which], axis=1)
    # beside an end of the edge the rim's own triangle may not hold it
    inside = np.minimum(share, 1 - share) * np.linalg.norm(way, axis=1)
    hit = (away <= reach[row]) & (inside > _BESIDE * away)
    hit[hit] = ~tables.bring_together(tables.edges[lines[row[hit]], 0], others[which[hit]])
    row, which, share = row[hit], which[hit], share[hit]
    return Points(lines[row], share, others[which], np.full(len(row), VERTEX), others[which])


def crossings_with(
    tables: Tables, net: Net, lines: IntArray, found: Points, mine: IntArray, reach: float
) -> tuple[Points, FloatArray]:
    """Return where the rim's edges pass over edges of the other, as new vertices, and their places."""
    edges = np.unique(tables.sides[mine])
    a, b = (net.vertices[tables.edges[lines, k]] for k in (0, 1))
    c, d = (net.vertices[tables.edges[edges, k]] for k in (0, 1))
    bulge = np.maximum(reach, BULGE * np.linalg.norm(b - a, axis=1))[:, None]
    low, high = np.minimum(a, b) - bulge, np.maximum(a, b) + bulge
    row, which = box_pairs(low, high, np.minimum(c, d), np.maximum(c, d)).T
    s, t, away, sine = approach(a[row], b[row], c[which], d[which])
    hit = (s > 0) & (s < 1) & (t > 0) & (t < 1) & (away <= bulge[row, 0]) & (sine > ALONG)
    row, which, s, t = row[hit], which[hit], s[hit], t[hit]
    # not where the rim already meets that edge: at a vertex of it, or in a point on it
    base = max(len(tables.edges), tables.count) + 1
    at_vertex = found.line[found.kind == VERTEX] * base + found.index[found.kind == VERTEX]
    at_edge = found.line[found.kind == EDGE] * base + found.index[found.kind == EDGE]
    met = np.isin(lines[row] * base + edges[which], at_edge)
    for k in (0, 1):
        met |= np.isin(lines[row] * base + tables.edges[edges[which], k], at_vertex)
    row, which, s, t = row[~met], which[~met], s[~met], t[~met]
    places = c[which] + t[:, None] * (d[which] - c[which])
    new = len(net.vertices) + np.arange(len(row))
    return Points(lines[row], s, new, np.full(len(row), EDGE), edges[which]), places


def approach(
    a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return where the lines ab and cd are nearest, as shares, how far apart, and the sine between them."""
    u, v, w = b - a, d - c, a - c
    uu, uv, vv = (np.einsum("ij,ij->i", x, y) for x, y in ((u, u), (u, v), (v, v)))
    uw, vw = (np.einsum("ij,ij->i", x, w) for x in (u, v))
    det = uu * vv - uv * uv
    safe = np.where(det > 0, det, 1.0)
    s, t = (uv * vw - vv * uw) / safe, (uu * vw - uv * uw) / safe
    away = np.linalg.norm(w + s[:, None] * u - t[:, None] * v, axis=1)
    return s, t, away, np.sqrt(np.maximum(det, 0.0) / (uu * vv))


def common_face(tables: Tables, found: Points, first: IntArray, mine: IntArray) -> IntArray:
    """Return a triangle of the other that holds a point and the next one, -1 where none does, shape (k,)."""
    rows, faces = [], []
    for kind, table in ((VERTEX, tables.around), (EDGE, tables.beneath)):
        some = np.flatnonzero(found.kind == kind)
        row, face = expanded(*table, found.index[some])
        rows.append(some[row])
        faces.append(face)
    some = np.flatnonzero(found.kind == FACE)
    row, face = np.concatenate([*rows, some]), np.concatenate([*faces, found.index[some]])
    own = np.isin(face, mine)
    base = len(tables.net.triangles)
    key = np.sort(row[own] * base + face[own])
    follows = np.isin(key + base, key)  # the next point lies in the same triangle
    row, face = key[follows] // base, key[follows] % base
    result = np.full(len(found.line), base)
    np.minimum.at(result, row, face)
    return np.where(result[first] < base, result[first], -1)


def along_edge(tables: Tables, found: Points, first: IntArray) -> BoolArray:
    """Return where a point and the next one lie on one edge of the other surface, shape (k,)."""
    (ka, ia), (kb, ib) = ((found.kind[r], found.index[r]) for r in (first, first + 1))
    corner = (ka == VERTEX) & (kb == VERTEX)
    same = corner.copy()
    same[corner] = tables.edge(ia[corner], ib[corner]) >= 0
    same |= (ka == EDGE) & (kb == EDGE) & (ia == ib)
    for edge_like, vertex_like, i, j in ((ka, kb, ia, ib), (kb, ka, ib, ia)):
        mixed = np.flatnonzero((edge_like == EDGE) & (vertex_like == VERTEX))
        same[mixed] |= (tables.edges[i[mixed]] == j[mixed][:, None]).any(axis=1)
    return np.asarray(same, dtype=np.bool_)


def on_rim(tables: Tables, found: Points, others: IntArray) -> BoolArray:
    """Return which points lie on the other's rim, given by its edges, shape (k,)."""
    vertex = (found.kind == VERTEX) & np.isin(found.index, tables.edges[others])
    return np.asarray(vertex | ((found.kind == EDGE) & np.isin(found.index, others)), dtype=np.bool_)
