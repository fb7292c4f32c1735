"""A rim that lies on another fault made edges of both (a T-contact, paper Sect. 9, limitation 5)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.cleaning.shaping.complex_mesh import FREE, Net, Tables, expanded, put_together, taken
from graben.cleaning.shaping.shared import among
from graben.cleaning.shaping.subdivision import Inserts, subdivided
from graben.proximity import box_pairs, boxes, nearest
from graben.validators.measuring.measures import components

#: Share of a rim's edge by which the other fault may bulge between two of its vertices that lie on it.
BULGE = 0.1
#: A vertex of the rim that comes to lie nearer to a corner or a side of the other's triangle than this share
#: of its shortest side is moved there: else a sliver would stand between them.
SNAP = 0.05
#: Sine of the angle below which two edges run along each other and do not cross.
_ALONG = 1e-3
#: A vertex is led into an edge of the rim where it is this many times further from its ends than off it.
_BESIDE = 2.0
#: How a point lies on a surface.
_VERTEX, _EDGE, _FACE = 0, 1, 2


@dataclass(frozen=True, eq=False)
class _Points:
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
        _VERTEX, _EDGE or _FACE of the other, and which.
    """

    line: IntArray
    share: FloatArray
    vertex: IntArray
    kind: IntArray
    index: IntArray

    def sorted(self) -> _Points:
        """Return the points by line, along it."""
        return self.some(np.lexsort((self.share, self.line)))

    def some(self, rows: IntArray | BoolArray) -> _Points:
        """Return some of the points."""
        return _Points(*(getattr(self, name)[rows] for name in ("line", "share", "vertex", "kind", "index")))

    def and_more(self, *more: _Points) -> _Points:
        """Return these points and others."""
        names = ("line", "share", "vertex", "kind", "index")
        return _Points(*(np.concatenate([getattr(p, name) for p in (self, *more)]) for name in names))


def imprinted(
    net: Net, own: int, other: int, reach: float, contact: float, places: FloatArray | None = None
) -> Net:
    """Return a net in which the rim of one surface, where it lies on another, is edges of both.

    The vertices of the rim within reach of the other are moved onto it and become vertices of it; where the
    rim's edges pass over edges of the other, both get a vertex.

    Parameters
    ----------
    net : Net
        Surfaces that share vertices by index.
    own, other : int
        The surface whose rim lies on the other, and the other.
    reach : float
        How far off the other a vertex of the rim may lie, model units.
    contact : float
        Distance at which two places are one, model units.
    places : (k, 3) array, optional
        Where given, only vertices at these places, equal to the bit, are moved.
    """
    near = _near(net, own, other, reach)
    part = _imprinted(taken(net, near), own, other, reach, contact, places)
    rest = taken(net, ~near)
    # new vertices come after the old ones, some of which the part has moved or merged: all others stay
    return put_together(replace(rest, vertices=part.vertices), part)


def _near(net: Net, own: int, other: int, reach: float) -> BoolArray:
    """Return which triangles lie where the boxes of two surfaces meet, or nearly do, shape (m,)."""
    low, high = boxes(net.vertices, net.triangles)
    mine, others = net.owner == own, net.owner == other
    if not mine.any() or not others.any():
        return np.asarray(mine & others, dtype=np.bool_)
    least = np.maximum(low[mine].min(axis=0), low[others].min(axis=0))
    most = np.minimum(high[mine].max(axis=0), high[others].max(axis=0))
    edge = float(np.linalg.norm(high - low, axis=1).max())
    wide = reach + edge
    return np.asarray(((high >= least - wide) & (low <= most + wide)).all(axis=1), dtype=np.bool_)


def _imprinted(
    net: Net, own: int, other: int, reach: float, contact: float, places: FloatArray | None
) -> Net:
    """Return a part of a net, with all that lies near to where the two meet, as :func:`imprinted` does."""
    tables = Tables(net, contact)
    rim = _rim(tables, own)
    mine = np.flatnonzero(net.owner == other)
    if not len(mine) or not len(rim):
        return net
    vertices = np.unique(tables.edges[rim])
    near = nearest(net.vertices[vertices], net.vertices, net.triangles[mine])
    on = near.distance <= reach
    if places is not None:
        on &= among(net.vertices[vertices], places)
    lines = rim[np.isin(tables.edges[rim], vertices[on]).all(axis=1)]
    lines = lines[~_shared(tables, lines, other)]
    on &= np.isin(vertices, tables.edges[lines])
    if not on.any():
        return net
    vertices = vertices[on]
    snap = np.maximum(contact, SNAP * _spacing(tables, rim, vertices))
    kind, index, place = _placed(
        net, tables, vertices, mine[near.simplex[on]], near.place[on], (snap, contact)
    )
    known = np.isin(vertices, net.triangles[mine])
    kind, index = np.where(known, _VERTEX, kind), np.where(known, vertices, index)
    points = net.vertices.copy()
    points[vertices[~known]] = place[~known]
    target = np.arange(len(points))
    target[vertices[kind == _VERTEX]] = index[kind == _VERTEX]
    moved = replace(net, vertices=points)
    found = _ends(tables, lines, vertices, kind, index)
    found = found.and_more(_vertices_on(tables, moved, lines, found, mine, contact)).sorted()
    more, places = _crossings(tables, moved, lines, found, mine, reach)
    moved = replace(moved, vertices=np.concatenate([points, places]))
    target = np.concatenate([target, np.arange(len(points), len(moved.vertices))])
    found = found.and_more(more).sorted()
    target = _merged(moved, np.unique(net.triangles[mine]), found.vertex, target, contact)
    inserts = _inserts(tables, moved, mine, found, (vertices[~known], kind[~known], index[~known]))
    return subdivided(moved, tables, inserts, target)


def _rim(tables: Tables, own: int) -> IntArray:
    """Return the edges at which a surface has one triangle."""
    sides = tables.sides[tables.net.owner == own].ravel()
    return np.flatnonzero(np.bincount(sides, minlength=len(tables.edges)) == 1)


def _spacing(tables: Tables, rim: IntArray, vertices: IntArray) -> FloatArray:
    """Return the length of the shorter of the rim's edges at each of some vertices, model units."""
    least = np.full(tables.count, np.inf)
    for k in (0, 1):
        np.minimum.at(least, tables.edges[rim, k], tables.lengths[rim])
    return least[vertices]


def _shared(tables: Tables, lines: IntArray, other: int) -> BoolArray:
    """Return which edges are edges of another surface already."""
    return np.asarray(np.isin(lines, tables.sides[tables.net.owner == other]), dtype=np.bool_)


def _placed(
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
    kind, index, where = np.full(len(rows), _FACE), triangle.copy(), place.copy()
    share = np.einsum("ijk,ijk->ij", place[:, None] - corners, sides) / size**2
    foot = corners + np.clip(share, 0, 1)[..., None] * sides
    away = np.linalg.norm(foot - place[:, None], axis=2)
    # a line of the other counts before what lies inside it: a rim beside it would leave a strip
    line = tables.held[tables.sides[triangle]][:, [2, 0, 1]] & (away <= near[:, None])
    k = np.where(line.any(axis=1), np.where(line, away, np.inf).argmin(axis=1), away.argmin(axis=1))
    hit = away[rows, k] <= near
    kind[hit], index[hit], where[hit] = _EDGE, tables.sides[triangle, (k + 2) % 3][hit], foot[rows, k][hit]
    away = np.linalg.norm(corners - place[:, None], axis=2)
    on_line = (tables.kind != FREE)[net.triangles[triangle]]
    away = np.where(line.any(axis=1)[:, None] & ~on_line, np.inf, away)
    k = away.argmin(axis=1)
    hit = (away[rows, k] <= near) & ~tables.bring_together(vertices, net.triangles[triangle, k])
    kind[hit], index[hit], where[hit] = _VERTEX, net.triangles[triangle, k][hit], corners[rows, k][hit]
    return kind, index, where


def _ends(tables: Tables, lines: IntArray, vertices: IntArray, kind: IntArray, index: IntArray) -> _Points:
    """Return the ends of the rim's edges as points on them."""
    ends = tables.edges[lines]
    at = np.searchsorted(vertices, ends)
    share = np.repeat([[0.0, 1.0]], len(lines), axis=0)
    return _Points(np.repeat(lines, 2), share.ravel(), ends.ravel(), kind[at].ravel(), index[at].ravel())


def _vertices_on(
    tables: Tables, net: Net, lines: IntArray, ends: _Points, mine: IntArray, contact: float
) -> _Points:
    """Return the other surface's vertices that lie on the inside of the rim's edges."""
    others = np.setdiff1d(np.unique(net.triangles[mine]), ends.index[ends.kind == _VERTEX])
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
    return _Points(lines[row], share, others[which], np.full(len(row), _VERTEX), others[which])


def _crossings(
    tables: Tables, net: Net, lines: IntArray, found: _Points, mine: IntArray, reach: float
) -> tuple[_Points, FloatArray]:
    """Return where the rim's edges pass over edges of the other, as new vertices, and their places."""
    edges = np.unique(tables.sides[mine])
    a, b = (net.vertices[tables.edges[lines, k]] for k in (0, 1))
    c, d = (net.vertices[tables.edges[edges, k]] for k in (0, 1))
    bulge = np.maximum(reach, BULGE * np.linalg.norm(b - a, axis=1))[:, None]
    low, high = np.minimum(a, b) - bulge, np.maximum(a, b) + bulge
    row, which = box_pairs(low, high, np.minimum(c, d), np.maximum(c, d)).T
    s, t, away, sine = _approach(a[row], b[row], c[which], d[which])
    hit = (s > 0) & (s < 1) & (t > 0) & (t < 1) & (away <= bulge[row, 0]) & (sine > _ALONG)
    row, which, s, t = row[hit], which[hit], s[hit], t[hit]
    # not where the rim already meets that edge: at a vertex of it, or in a point on it
    base = max(len(tables.edges), tables.count) + 1
    at_vertex = found.line[found.kind == _VERTEX] * base + found.index[found.kind == _VERTEX]
    at_edge = found.line[found.kind == _EDGE] * base + found.index[found.kind == _EDGE]
    met = np.isin(lines[row] * base + edges[which], at_edge)
    for k in (0, 1):
        met |= np.isin(lines[row] * base + tables.edges[edges[which], k], at_vertex)
    row, which, s, t = row[~met], which[~met], s[~met], t[~met]
    places = c[which] + t[:, None] * (d[which] - c[which])
    new = len(net.vertices) + np.arange(len(row))
    return _Points(lines[row], s, new, np.full(len(row), _EDGE), edges[which]), places


def _approach(
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


def _merged(net: Net, others: IntArray, inserted: IntArray, target: IntArray, contact: float) -> IntArray:
    """Return the targets of vertices, those at one place made one: a vertex of the other first."""
    new = np.setdiff1d(target[inserted], others)
    some = np.concatenate([others, new])
    pairs = cKDTree(net.vertices[some]).query_pairs(contact, output_type="ndarray")
    pairs = pairs[(pairs >= len(others)).any(axis=1)]
    if not len(pairs):
        return target
    label = components(len(some), pairs)
    first = np.unique(label, return_index=True)[1]
    onward = np.arange(len(target))
    onward[some] = some[first[label]]
    return onward[target]


def _inserts(
    tables: Tables, net: Net, mine: IntArray, found: _Points, moved: tuple[IntArray, IntArray, IntArray]
) -> Inserts:
    """Return what both surfaces are divided at; an edge whose points share no triangles is left as it is."""
    first = np.flatnonzero(found.line[:-1] == found.line[1:])
    face = _common_face(tables, found, first, mine)
    sound = ~np.isin(found.line, found.line[first[face < 0]])
    whole = sound[first]
    first, face = first[whole], face[whole]
    inner = sound & (found.share > 0) & (found.share < 1)
    crossing = inner & (found.kind == _EDGE)
    vertex, kind, index = moved
    edges = np.concatenate([found.line[inner], index[kind == _EDGE], found.index[crossing]])
    vertices = np.concatenate([found.vertex[inner], vertex[kind == _EDGE], found.vertex[crossing]])
    a, b = (net.vertices[tables.edges[edges, k]] for k in (0, 1))
    shares = np.einsum("ij,ij->i", net.vertices[vertices] - a, b - a)
    across = ~_along_edge(tables, found, first)
    return Inserts(
        edges,
        vertices,
        shares,
        index[kind == _FACE],
        vertex[kind == _FACE],
        face[across],
        np.stack([found.vertex[first[across]], found.vertex[first[across] + 1]], axis=1),
    )


def _common_face(tables: Tables, found: _Points, first: IntArray, mine: IntArray) -> IntArray:
    """Return a triangle of the other that holds a point and the next one, -1 where none does, shape (k,)."""
    rows, faces = [], []
    for kind, table in ((_VERTEX, tables.around), (_EDGE, tables.beneath)):
        some = np.flatnonzero(found.kind == kind)
        row, face = expanded(*table, found.index[some])
        rows.append(some[row])
        faces.append(face)
    some = np.flatnonzero(found.kind == _FACE)
    row, face = np.concatenate([*rows, some]), np.concatenate([*faces, found.index[some]])
    own = np.isin(face, mine)
    base = len(tables.net.triangles)
    key = np.sort(row[own] * base + face[own])
    follows = np.isin(key + base, key)  # the next point lies in the same triangle
    row, face = key[follows] // base, key[follows] % base
    result = np.full(len(found.line), base)
    np.minimum.at(result, row, face)
    return np.where(result[first] < base, result[first], -1)


def _along_edge(tables: Tables, found: _Points, first: IntArray) -> BoolArray:
    """Return where a point and the next one lie on one edge of the other surface, shape (k,)."""
    (ka, ia), (kb, ib) = ((found.kind[r], found.index[r]) for r in (first, first + 1))
    corner = (ka == _VERTEX) & (kb == _VERTEX)
    same = corner.copy()
    same[corner] = tables.edge(ia[corner], ib[corner]) >= 0
    same |= (ka == _EDGE) & (kb == _EDGE) & (ia == ib)
    for edge_like, vertex_like, i, j in ((ka, kb, ia, ib), (kb, ka, ib, ia)):
        mixed = np.flatnonzero((edge_like == _EDGE) & (vertex_like == _VERTEX))
        same[mixed] |= (tables.edges[i[mixed]] == j[mixed][:, None]).any(axis=1)
    return np.asarray(same, dtype=np.bool_)
