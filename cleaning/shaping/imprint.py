"""A rim that lies on another fault made edges of both (a T-contact, paper Sect. 9, limitation 5)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, ints
from graben.cleaning.shaping.complex_mesh import Net, Tables, put_together, taken
from graben.cleaning.shaping.rim_points import (
    ALONG,
    BULGE,
    EDGE,
    FACE,
    SNAP,
    VERTEX,
    Points,
    along_edge,
    approach,
    common_face,
    crossings_with,
    ends_on,
    on_rim,
    placed,
    vertices_on,
)
from graben.cleaning.shaping.shared import among
from graben.cleaning.shaping.subdivision import Inserts, subdivided
from graben.proximity import box_pairs, boxes, nearest
from graben.validators.measuring.measures import components


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
    others = _rim(tables, other)
    lines = _lines(tables, rim[~_shared(tables, rim, other)], others, vertices[on], reach, places)
    if not len(lines):
        return net
    on &= np.isin(vertices, tables.edges[lines])
    vertices = vertices[on]
    snap = np.maximum(contact, SNAP * _spacing(tables, rim, vertices))
    kind, index, place = placed(
        net, tables, vertices, mine[near.simplex[on]], near.place[on], (snap, contact)
    )
    known = np.isin(vertices, net.triangles[mine])
    kind, index = np.where(known, VERTEX, kind), np.where(known, vertices, index)
    points = net.vertices.copy()
    points[vertices[~known]] = place[~known]
    target = np.arange(len(points))
    target[vertices[kind == VERTEX]] = index[kind == VERTEX]
    moved = replace(net, vertices=points)
    found = ends_on(tables, lines, vertices, kind, index)
    found = found.and_more(vertices_on(tables, moved, lines, found, mine, contact)).sorted()
    more, places = crossings_with(tables, moved, lines, found, mine, reach)
    moved = replace(moved, vertices=np.concatenate([points, places]))
    target = np.concatenate([target, np.arange(len(points), len(moved.vertices))])
    found = found.and_more(more).sorted()
    target = _merged(moved, np.unique(net.triangles[mine]), found.vertex, target, contact)
    inserts = _inserts(tables, moved, mine, others, found, (vertices[~known], kind[~known], index[~known]))
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


def _lines(
    tables: Tables, rim: IntArray, others: IntArray, on: IntArray, reach: float, places: FloatArray | None
) -> IntArray:
    """Return the edges of a rim that lie on the other surface, wholly or in part.

    Parameters
    ----------
    tables : Tables
        Of the net.
    rim, others : arrays of int
        The edges of the rim, and those of the other's.
    on : (k,) array
        The vertices that lie on the other; an edge with two of them lies on it wholly.
    reach, places
        As of :func:`imprinted`; of an edge that lies on it in part both ends are at these places.
    """
    held = np.isin(tables.edges[rim], on).sum(axis=1)
    part = held < 2
    if places is not None:
        ends = tables.net.vertices[tables.edges[rim]]
        part &= among(ends.reshape(-1, 3), places).reshape(-1, 2).all(axis=1)
    part[part] = _leaves(tables, rim[part], others, held[part], reach)
    return ints(rim[(held == 2) | part])


def _leaves(tables: Tables, rim: IntArray, others: IntArray, held: IntArray, reach: float) -> BoolArray:
    """Return which edges of a rim leave the other surface over the other's rim.

    ``held``: how many of the ends of each lie on the other. With one it passes over the other's rim once or
    more, with none twice or more. Without an end that holds it there, it must lie within reach.
    """
    points = tables.net.vertices
    a, b = (points[tables.edges[rim, k]] for k in (0, 1))
    c, d = (points[tables.edges[others, k]] for k in (0, 1))
    wide = np.where(held > 0, np.maximum(reach, BULGE * tables.lengths[rim]), reach)
    low, high = np.minimum(a, b) - wide[:, None], np.maximum(a, b) + wide[:, None]
    row, which = box_pairs(low, high, np.minimum(c, d), np.maximum(c, d)).T
    s, t, away, sine = approach(a[row], b[row], c[which], d[which])
    hit = (s > 0) & (s < 1) & (t >= 0) & (t <= 1) & (away <= wide[row]) & (sine > ALONG)
    return np.asarray(np.bincount(row[hit], minlength=len(rim)) >= 2 - held, dtype=np.bool_)


def _shared(tables: Tables, lines: IntArray, other: int) -> BoolArray:
    """Return which edges are edges of another surface already."""
    return np.asarray(np.isin(lines, tables.sides[tables.net.owner == other]), dtype=np.bool_)


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
    tables: Tables,
    net: Net,
    mine: IntArray,
    others: IntArray,
    found: Points,
    moved: tuple[IntArray, IntArray, IntArray],
) -> Inserts:
    """Return what both surfaces are divided at; an edge that cannot be followed is left as it is."""
    first = np.flatnonzero(found.line[:-1] == found.line[1:])
    face = common_face(tables, found, first, mine)
    sound = ~np.isin(found.line, _unsound(found, first[face < 0], on_rim(tables, found, others)))
    whole = sound[first] & (face >= 0)
    first, face = first[whole], face[whole]
    inner = sound & (found.share > 0) & (found.share < 1)
    crossing = inner & (found.kind == EDGE)
    vertex, kind, index = moved
    edges = np.concatenate([found.line[inner], index[kind == EDGE], found.index[crossing]])
    vertices = np.concatenate([found.vertex[inner], vertex[kind == EDGE], found.vertex[crossing]])
    a, b = (net.vertices[tables.edges[edges, k]] for k in (0, 1))
    shares = np.einsum("ij,ij->i", net.vertices[vertices] - a, b - a)
    across = ~along_edge(tables, found, first)
    return Inserts(
        edges,
        vertices,
        shares,
        index[kind == FACE],
        vertex[kind == FACE],
        face[across],
        np.stack([found.vertex[first[across]], found.vertex[first[across] + 1]], axis=1),
    )


def _unsound(found: Points, apart: IntArray, at_rim: BoolArray) -> IntArray:
    """Return the edges of a rim that are not known to lie on the other surface all along.

    Where the other has no triangle from one point to the next, or an end has no point on it, the edge has
    left the other: over the other's rim, or its course is not known.

    Parameters
    ----------
    found : Points
        By line, along it.
    apart : (k,) array
        The points that share no triangle of the other with the next one.
    at_rim : (points,) array
        Which of them lie on the other's rim.
    """
    lost = apart[~(at_rim[apart] & at_rim[apart + 1])]
    turn = found.line[1:] != found.line[:-1]
    open_ = (np.r_[True, turn] & (found.share > 0)) | (np.r_[turn, True] & (found.share < 1))
    return np.concatenate([found.line[lost], found.line[open_ & ~at_rim]])
