"""The segments on which two surfaces meet, exactly or to the contact distance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, ints
from graben.complexes import Complex
from graben.proximity import box_pairs, nearest
from graben.surface import Surface, edge_sharing, edge_table
from graben.validators.measuring.measures import components
from graben.validators.measuring.slabs import merged, overlaps
from graben.validators.measuring.surroundings import Facets

#: Places that are one, in contact distances.
ONE = 2.0
#: How far a line that leaves a surface may seem to lie on it beyond its rim, in contact distances.
_BEYOND = 10.0
#: What is closer is exact but for rounding, in contact distances.
EXACT = 1e-3
#: Sine of the angle between planes below which triangles may lie on each other: no steeper, and an area a
#: hundred contact distances wide stays within one.
_FLATNESS = 0.01


class Source(IntEnum):
    """By what a segment was found."""

    SHARED = 0  #: an edge that both have in the common refinement
    FIRST = 1  #: a stretch of an edge of the first surface, on the second
    SECOND = 2  #: the other way round
    COMMON = 3  #: an edge that both surfaces have, equal to the bit


@dataclass(frozen=True, eq=False)
class Mesh:
    """A surface whose vertices are one where they are equal to the bit, across all surfaces.

    Parameters
    ----------
    vertices : (n, 3) array
        Of all surfaces, model units.
    facets : Facets
        Its triangles.
    edges : (e, 2) array
        Vertex indices.
    sides : (m, 3) array
        Edges of each triangle.
    rim : (e,) array
        Which edges have one triangle alone.
    low, high : (3,) arrays
        Its box.
    """

    vertices: FloatArray
    facets: Facets
    edges: IntArray
    sides: IntArray
    rim: BoolArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True, eq=False)
class Lines:
    """Segments on which two surfaces meet.

    Parameters
    ----------
    ends : (n, 2, 3) array
        Model units.
    source : (n,) array
        :class:`Source` of each.
    edge : (n,) array
        The edge of the first or second surface that it is a stretch of; -1 for others.
    whole : (n,) array
        Whether it is the whole of that edge.
    """

    ends: FloatArray
    source: IntArray
    edge: IntArray
    whole: BoolArray

    @property
    def lengths(self) -> FloatArray:
        """Length of each, model units."""
        return np.asarray(np.linalg.norm(self.ends[:, 1] - self.ends[:, 0], axis=1))

    @property
    def middles(self) -> FloatArray:
        """Middle of each, shape (n, 3)."""
        return np.asarray(self.ends.mean(axis=1))


def meshes(surfaces: Sequence[Surface]) -> list[Mesh]:
    """Return surfaces as meshes over one list of vertices."""
    points = np.concatenate([s.vertices for s in surfaces]) + 0.0  # +0.0: minus zero is zero
    _, first, index = np.unique(points.view("V24").ravel(), return_index=True, return_inverse=True)
    vertices, index = points[first], index.reshape(-1)
    starts = np.cumsum([0] + [len(s.vertices) for s in surfaces])
    return [_mesh(vertices, index[k:][s.triangles]) for s, k in zip(surfaces, starts, strict=False)]


def _mesh(vertices: FloatArray, triangles: IntArray) -> Mesh:
    edges, sides = edge_table(triangles)
    facets = Facets.made(vertices, triangles)
    low, high = facets.low.min(axis=0, initial=np.inf), facets.high.max(axis=0, initial=-np.inf)
    return Mesh(vertices, facets, edges, sides, edge_sharing(sides, len(edges)) == 1, low, high)


def shared_edges(network: Complex) -> dict[tuple[int, int], FloatArray]:
    """Return the edges (e, 2, 3) that two surfaces of a complex share, by the pair, the smaller first."""
    edges, sides = network.edges()
    count = int(network.owner.max(initial=0)) + 1
    uses = np.unique(sides * count + network.owner[:, None])
    edge, owner = uses // count, uses % count
    rows = [np.zeros((0, 2), dtype=np.int64)]
    for step in range(1, count):
        same = np.flatnonzero(edge[step:] == edge[:-step])
        if not len(same):
            break
        rows.append(np.stack([owner[same] * count + owner[same + step], edge[same]], axis=1))
    table = np.concatenate(rows)
    table = table[np.argsort(table[:, 0], kind="stable")]
    keys, start = np.unique(table[:, 0], return_index=True)
    parts = np.split(table[:, 1], start[1:]) if len(keys) else []
    return {
        (int(k) // count, int(k) % count): network.vertices[edges[part]]
        for k, part in zip(keys, parts, strict=True)
    }


@dataclass(frozen=True, eq=False)
class Touch:
    """What two surfaces have in common, exactly or to the contact distance.

    Parameters
    ----------
    lines : Lines
        The segments on which they meet.
    common : (t, 3, 3) array
        Corners of the triangles in which they lie on each other, model units.
    triangles : (t, 2) array
        The triangles of the surfaces that each is common to.
    near : tuple of two Facets
        The triangles of either that come near the other.
    """

    lines: Lines
    common: FloatArray
    triangles: IntArray
    near: tuple[Facets, Facets]


def touching(one: Mesh, other: Mesh, shared: FloatArray, tolerance: float) -> Touch | None:
    """Return what two surfaces have in common, None where they keep apart.

    Parameters
    ----------
    one, other : Mesh
        The surfaces.
    shared : (e, 2, 3) array
        The edges that both have in their common refinement.
    tolerance : float
        Distance at which two surfaces touch, model units.
    """
    a = one.facets.within(other.low - tolerance, other.high + tolerance)
    b = other.facets.within(one.low - tolerance, one.high + tolerance)
    pairs = box_pairs(a.low - tolerance, a.high + tolerance, b.low, b.high, a.along)
    if not len(pairs):
        return None
    near_a, i = np.unique(pairs[:, 0], return_inverse=True)
    near_b, j = np.unique(pairs[:, 1], return_inverse=True)
    a, b = a.of(near_a), b.of(near_b)
    pair, common = overlaps(a.corners[i], b.corners[j], tolerance, _FLATNESS)
    found = [
        _of(shared, Source.SHARED),
        _lying(one, a.index[i], b, j, tolerance, Source.FIRST),
        _lying(other, b.index[j], a, i, tolerance, Source.SECOND),
        _of(_common_edges(one, a.index, other, b.index), Source.COMMON),
    ]
    lines = Lines(
        np.concatenate([p.ends for p in found]),
        np.concatenate([p.source for p in found]),
        np.concatenate([p.edge for p in found]),
        np.concatenate([p.whole for p in found]),
    )
    if not len(lines.source):
        return None
    return Touch(lines, common, np.stack([a.index[i[pair]], b.index[j[pair]]], axis=1), (a, b))


def _of(ends: FloatArray, source: Source) -> Lines:
    n = len(ends)
    return Lines(ends, np.full(n, source), np.full(n, -1), np.zeros(n, dtype=bool))


def _common_edges(one: Mesh, triangles: IntArray, other: Mesh, others: IntArray) -> FloatArray:
    """Return the edges (e, 2, 3) that triangles of both surfaces have, equal to the bit."""
    n = len(one.vertices)
    first, second = (m.edges[np.unique(m.sides[t])] for m, t in ((one, triangles), (other, others)))
    both = np.intersect1d(first[:, 0] * n + first[:, 1], second[:, 0] * n + second[:, 1])
    return np.asarray(one.vertices[np.stack([both // n, both % n], axis=1)])


def _lying(
    mesh: Mesh, triangles: IntArray, on: Facets, facet: IntArray, tolerance: float, source: Source
) -> Lines:
    """Return the stretches of the edges of triangles that lie on the facets paired with those."""
    keys = np.unique(mesh.sides[triangles] * len(on.index) + facet[:, None])
    edge, facet = keys // len(on.index), keys % len(on.index)
    ends = mesh.vertices[mesh.edges[edge]]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    first, last = on.slabs.stretches(ends, facet, tolerance)
    # an end that runs on beyond the other's rim is cut off there; not so where two rims run side by side
    begin, end = on.slabs.stretches(ends, facet, tolerance, EXACT * tolerance)
    beyond = _BEYOND * tolerance / np.where(length > 0, length, np.inf)
    inside = begin <= end
    first = np.where(inside & (begin - first <= beyond), begin, first)
    last = np.where(inside & (last - end <= beyond), end, last)
    hit = (first <= last) & (length > 0)
    edge, first, last = merged(edge[hit], first[hit], last[hit], tolerance / length[hit])
    start, end = (mesh.vertices[mesh.edges[edge, k]] for k in (0, 1))
    stretch = np.stack([start + t[:, None] * (end - start) for t in (first, last)], axis=1)
    return Lines(stretch, np.full(len(edge), source), edge, (first <= 0) & (last >= 1))


def pieces(touch: Touch, tolerance: float) -> tuple[IntArray, IntArray]:
    """Return the connected pieces in which two surfaces meet, as numbers.

    What lies within a few tolerances of each other is joined.

    Returns
    -------
    lines, common : (n,) and (t,) arrays
        The piece of each segment and of each common triangle.
    """
    lines, reach = touch.lines, ONE * tolerance
    nodes = lines.ends.reshape(-1, 3)
    n = len(nodes)
    links = [np.arange(n).reshape(-1, 2), cKDTree(nodes).query_pairs(reach, output_type="ndarray")]
    # an edge that passes through the other surface comes near the line in its middle alone
    points = np.stack([lines.ends[:, 0], lines.middles, lines.ends[:, 1]], axis=1)
    for source in np.unique(lines.source):
        mine = np.flatnonzero(lines.source == source)
        links.append(_near(points[mine], 2 * mine, lines, lines.source != source, reach))
    # the sides of a common triangle are stretches of edges of both, which cross in its corners
    common = n + np.arange(len(touch.common))
    for source in (Source.FIRST, Source.SECOND):
        links.append(_near(touch.common[:, 1:2], common, lines, lines.source == source, reach))
    label = components(n + len(common), np.concatenate(links))
    return ints(label[:n:2]), ints(label[n:])


def _near(points: FloatArray, nodes: IntArray, lines: Lines, among: BoolArray, reach: float) -> IntArray:
    """Return the links of nodes, each with points (n, k, 3), to the first ends of the segments near those."""
    # segments without length are nodes alone
    others = np.flatnonzero(among & (lines.lengths > 0))
    if not len(others):
        return np.zeros((0, 2), dtype=np.int64)
    sides = np.stack([2 * others, 2 * others + 1], axis=1)
    there = nearest(points.reshape(-1, 3), lines.ends.reshape(-1, 3), sides)
    near = there.distance <= reach
    from_nodes = np.repeat(nodes, points.shape[1])
    return np.stack([from_nodes[near], 2 * others[there.simplex[near]]], axis=1)
