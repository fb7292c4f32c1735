"""Passes that better the triangles of a complex without parting its surfaces: collapse, flip, snap.

Surfaces of a complex share vertices by index, so whatever is done to vertices and edges is done to all of
them at once. Each pass makes many changes at a time, no two of which concern the same triangle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, bools
from graben.cleaning.shaping.complex_mesh import (
    CURVE,
    FIXED,
    FREE,
    Net,
    Tables,
    angles,
    expanded,
    independent,
    put_together,
    taken,
)

#: A triangle may turn by at most this from the surface of the input that it stands for, degrees.
TURN = 40.0
#: By how much the least angle must grow for a change to be worth it, degrees.
GAIN = 0.05
#: The share of the least angle that must be left where a short side goes.
KEPT = 0.5
#: A triangle with a larger angle than this is a cap: its longest side is the trouble, degrees.
CAP = 130.0


@dataclass(frozen=True)
class Goal:
    """What the passes aim at.

    Parameters
    ----------
    angle : float
        Triangles with a smaller angle are worked on, degrees.
    off : float
        How far a vertex or a line may lie off the surfaces that it leaves, model units.
    """

    angle: float
    off: float


#: What a pass looks at around a bad triangle: so many rings of triangles.
_RINGS = 3


def around_bad(net: Net, goal: Goal) -> BoolArray:
    """Return which triangles lie so near to a bad one that a change of that may concern them, shape (m,)."""
    near = bools(np.isin(np.arange(len(net.triangles)), _bad(net, goal)))
    for _ in range(_RINGS):
        vertex = np.zeros(len(net.vertices), dtype=np.bool_)
        vertex[net.triangles[near]] = True
        near = bools(vertex[net.triangles].any(axis=1))
    return near


def _bad(net: Net, goal: Goal) -> IntArray:
    """Return the fresh triangles with too small an angle."""
    fresh = np.flatnonzero(net.fresh)
    return np.asarray(fresh[angles(net.vertices[net.triangles[fresh]]).min(axis=1) < goal.angle])


def collapsed(net: Net, goal: Goal) -> tuple[Net, int]:
    """Return a net in which sides of bad triangles are collapsed to one of their ends.

    The end that stays keeps its place, so no vertex ever moves. A vertex on a line goes along it only.

    Parameters
    ----------
    net : Net
        The complex.
    goal : Goal
        What is bad, and what may be done about it.

    Returns
    -------
    net : Net
        The new one.
    count : int
        How many vertices went.
    """
    tables = Tables(net, goal.off)
    gone, kept = _candidates(tables, goal)
    if not len(gone):
        return net, 0
    better, gain = _gains(tables, goal, gone, kept)
    gone, kept, gain = gone[better], kept[better], gain[better]
    order = np.lexsort((kept, gone, -gain))
    # of the two ways along an edge, and of all ways of a vertex, the best counts: the rest loses its claims
    gone, kept = gone[order], kept[order]
    chosen = _apart(tables, gone, kept)
    gone, kept = gone[chosen], kept[chosen]
    target = np.arange(len(net.vertices))
    target[gone] = kept
    return renumbered(net, target), len(gone)


def _candidates(tables: Tables, goal: Goal) -> tuple[IntArray, IntArray]:
    """Return the ways in which sides of bad triangles may be collapsed: the vertex that goes, and whereto."""
    net = tables.net
    bad = _bad(net, goal)
    edge = np.unique(tables.sides[bad])
    pairs = np.concatenate([tables.edges[edge], tables.edges[edge][:, ::-1]])
    edge = np.concatenate([edge, edge])
    of = tables.kind[pairs[:, 0]]
    # two ends of lines that are nearer than any move that counts are one
    tiny = tables.held[edge] & (tables.lengths[edge] <= goal.off)
    tiny[tiny] = ~tables.bring_together(*pairs[tiny].T)
    may = (of == FREE) | ((of == CURVE) & tables.held[edge]) | ((of == FIXED) & tiny)
    pairs = pairs[may]
    # an edge is sound to collapse where its ends have no neighbours in common but across its triangles
    sound = tables.common(pairs[:, 0], pairs[:, 1]) == tables.sharing[edge[may]]
    return pairs[sound, 0], pairs[sound, 1]


def _gains(tables: Tables, goal: Goal, gone: IntArray, kept: IntArray) -> tuple[BoolArray, FloatArray]:
    """Return which collapses are allowed and better, and by how much the least angle grows, degrees."""
    net = tables.net
    row, triangle = tables.star(gone)
    corners = net.triangles[triangle]
    goes = (corners == kept[row][:, None]).any(axis=1)
    before = np.full(len(gone), np.inf)
    np.minimum.at(before, row, angles(net.vertices[corners]).min(axis=1))
    row, triangle = row[~goes], triangle[~goes]
    corners = np.where(
        net.triangles[triangle] == gone[row][:, None], kept[row][:, None], net.triangles[triangle]
    )
    points = net.vertices[corners]
    after = np.full(len(gone), np.inf)
    np.minimum.at(after, row, angles(points).min(axis=1))
    normal = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    size = np.linalg.norm(normal, axis=1)
    along = np.einsum("ij,ij->i", normal, net.normals[triangle])
    turned = np.bincount(row[along < np.cos(np.radians(TURN)) * size], minlength=len(gone)) > 0
    away = _off(tables, gone, kept, row, triangle, points)
    # around several needles the least angle is that of the next one: a short side may go without a gain
    short = np.linalg.norm(net.vertices[gone] - net.vertices[kept], axis=1) <= goal.off
    better = (after > before + GAIN) | (short & (after >= KEPT * before))
    better &= ~turned & (away <= goal.off)
    return np.asarray(better, dtype=np.bool_), np.where(np.isinf(after), 180.0, after) - before


def _off(
    tables: Tables, gone: IntArray, kept: IntArray, row: IntArray, triangle: IntArray, points: FloatArray
) -> FloatArray:
    """Return how far a vertex that goes lies off what takes its place: every surface and every line of it.

    Off a surface: the least distance from the planes of the new triangles of an owner, the largest of owners.
    Off a line: the distance from the new edge of that line.
    """
    net = tables.net
    place = net.vertices[gone]
    normal = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]
    height = np.abs(np.einsum("ij,ij->i", place[row] - points[:, 0], normal))
    owners = int(net.owner.max()) + 1
    key, inverse = np.unique(row * owners + net.owner[triangle], return_inverse=True)
    least = np.full(len(key), np.inf)
    np.minimum.at(least, inverse.reshape(-1), height)
    off = np.zeros(len(gone))
    np.maximum.at(off, key // owners, least)
    others, starts = tables.beside
    curve = np.flatnonzero(tables.kind[gone] != FREE)
    at, other = expanded(others, starts, gone[curve])
    lines = tables.held[tables.edge(gone[curve][at], other)] & (other != kept[curve][at])
    at, other = curve[at[lines]], other[lines]
    way = net.vertices[other] - net.vertices[kept[at]]
    reach = place[at] - net.vertices[kept[at]]
    share = np.einsum("ij,ij->i", reach, way) / np.maximum(
        np.einsum("ij,ij->i", way, way), np.finfo(float).tiny
    )
    gap = np.linalg.norm(reach - np.clip(share, 0, 1)[:, None] * way, axis=1)
    np.maximum.at(off, at, gap)
    return off


def _apart(tables: Tables, gone: IntArray, kept: IntArray) -> BoolArray:
    """Return which of some collapses, in order of priority, concern no triangle of another."""
    row, triangle = tables.star(gone)
    more, beside = tables.star(kept)
    return independent(
        len(gone), np.concatenate([row, more]), np.concatenate([triangle, beside]), len(tables.net.triangles)
    )


def flipped(net: Net, goal: Goal) -> tuple[Net, int]:
    """Return a net in which the longest sides of bad triangles are flipped where that helps.

    Parameters and returns as of :func:`collapsed`; the count is that of flips.
    """
    tables = Tables(net, goal.off)
    corner = angles(net.vertices[net.triangles])
    bad = np.flatnonzero(net.fresh & (corner.min(axis=1) < goal.angle))
    if not len(bad):
        return net, 0
    edge = tables.sides[bad][np.arange(len(bad)), corner[bad].argmax(axis=1)]
    edge = np.unique(edge[~tables.held[edge]])
    first, second, quad = _quads(tables, edge)
    c, d = quad[:, 2], quad[:, 3]
    new = np.stack([quad[:, [0, 3, 2]], quad[:, [3, 1, 2]]], axis=1)  # (a, d, c), (d, b, c)
    points = net.vertices[new]
    normal = np.cross(points[:, :, 1] - points[:, :, 0], points[:, :, 2] - points[:, :, 0])
    size = np.linalg.norm(normal, axis=2)
    old = np.stack([net.normals[first], net.normals[second]], axis=1)
    turned = (np.einsum("eik,ejk->eij", normal, old) < np.cos(np.radians(TURN)) * size[:, :, None]).any(
        (1, 2)
    )
    before = np.minimum(corner[first].min(axis=1), corner[second].min(axis=1))
    after = angles(points.reshape(-1, 3, 3)).min(axis=1).reshape(-1, 2).min(axis=1)
    a, b = net.vertices[quad[:, 0]], net.vertices[quad[:, 1]]
    better = (after > before + GAIN) & ~turned & (tables.edge(c, d) < 0)
    better &= _between(a, b, net.vertices[c], net.vertices[d]) <= goal.off
    rows = np.flatnonzero(better)
    rows = rows[np.lexsort((edge[rows], -(after - before)[rows]))]
    if not len(rows):
        return net, 0
    chosen = rows[_flips_apart(tables, quad[rows])]
    triangles = net.triangles.copy()
    triangles[first[chosen]], triangles[second[chosen]] = new[chosen, 0], new[chosen, 1]
    return replace(net, triangles=triangles), len(chosen)


def _quads(tables: Tables, edge: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return the two triangles of edges and their corners a, b, c, d: (a, b, c) turns as the first does."""
    triangles = tables.net.triangles
    order, starts = tables.corners_at
    one, two = order[starts[edge]], order[starts[edge] + 1]
    first, corner = one // 3, one % 3
    at = np.arange(len(edge))
    a, b = (triangles[first][at, (corner + k) % 3] for k in (1, 2))
    return first, two // 3, np.stack([a, b, triangles.ravel()[one], triangles.ravel()[two]], axis=1)


def _flips_apart(tables: Tables, quad: IntArray) -> BoolArray:
    """Return which flips concern no triangle around the corners of another, in order of priority."""
    row, triangle = tables.star(quad.ravel())
    return independent(len(quad), row // 4, triangle, len(tables.net.triangles))


def _between(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Return the distance between the lines ab and cd, shape (n,): the height of their tetrahedron."""
    across = np.cross(b - a, d - c)
    size = np.maximum(np.linalg.norm(across, axis=1), np.finfo(float).tiny)
    return np.asarray(np.abs(np.einsum("ij,ij->i", c - a, across)) / size)


def snapped(net: Net, goal: Goal) -> tuple[Net, int]:
    """Return a net in which lines are led through vertices that nearly lie on them.

    A bad triangle whose long side lies on a line, with its third corner hardly off it, goes: the line passes
    through that corner, and whatever else meets at the side is split there.

    Parameters and returns as of :func:`collapsed`; the count is that of triangles that went.
    """
    tables = Tables(net, goal.off)
    corner = angles(net.vertices[net.triangles])
    bad = np.flatnonzero(net.fresh & (corner.min(axis=1) < goal.angle) & (corner.max(axis=1) > CAP))
    most = corner[bad].argmax(axis=1)
    edge, apex = tables.sides[bad, most], net.triangles[bad, most]
    height = _heights(tables, edge, apex)
    keep = tables.held[edge] & (height <= goal.off)
    keep[keep] = ~tables.bring_together(tables.edges[edge[keep], 0], apex[keep])
    bad, edge, apex, height = bad[keep], edge[keep], apex[keep], height[keep]
    order = np.lexsort((edge, height))
    bad, edge, apex = bad[order], edge[order], apex[order]
    if not len(bad):
        return net, 0
    ends = tables.edges[edge]
    row, triangle = tables.star(np.column_stack([ends, apex]).ravel())
    chosen = independent(len(bad), row // 3, triangle, len(net.triangles))
    chosen &= _may_split(tables, goal, bad, edge, apex)
    bad, edge, apex = bad[chosen], edge[chosen], apex[chosen]
    through = np.full(len(tables.edges), -1)
    through[edge] = apex
    side = through[tables.sides]
    hit = np.flatnonzero((side >= 0).any(axis=1))
    hit = hit[~np.isin(hit, bad)]
    at = (side[hit] >= 0).argmax(axis=1)
    rows = np.arange(len(hit))
    new = side[hit, at]
    opposite, one, two = (net.triangles[hit][rows, (at + k) % 3] for k in range(3))
    triangles = net.triangles.copy()
    triangles[hit] = np.stack([opposite, one, new], axis=1)
    added = np.stack([opposite, new, two], axis=1)
    stays = np.ones(len(triangles), dtype=bool)
    stays[bad] = False
    second = replace(taken(net, hit), triangles=added, fresh=np.ones(len(hit), dtype=np.bool_))
    return put_together(taken(replace(net, triangles=triangles), stays), second), len(bad)


def _heights(tables: Tables, edge: IntArray, apex: IntArray) -> FloatArray:
    """Return how far vertices lie off edges, model units."""
    points = tables.net.vertices
    a, b = points[tables.edges[edge, 0]], points[tables.edges[edge, 1]]
    across = np.linalg.norm(np.cross(b - a, points[apex] - a), axis=1)
    return np.asarray(across / np.maximum(tables.lengths[edge], np.finfo(float).tiny))


def _may_split(tables: Tables, goal: Goal, bad: IntArray, edge: IntArray, apex: IntArray) -> BoolArray:
    """Return where the other triangles at an edge can be split at a vertex new to them, and none turns."""
    net = tables.net
    row, position = expanded(*tables.corners_at, edge)
    triangle, corner = position // 3, position % 3
    other = triangle != bad[row]
    row, triangle, corner = row[other], triangle[other], corner[other]
    at = np.arange(len(row))
    opposite, one, two = (net.triangles[triangle][at, (corner + k) % 3] for k in range(3))
    known = tables.edge(opposite, apex[row]) >= 0
    wrong = known.copy()
    for corners in ((opposite, one, apex[row]), (opposite, apex[row], two)):
        points = net.vertices[np.stack(corners, axis=1)]
        normal = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
        along = np.einsum("ij,ij->i", normal, net.normals[triangle])
        wrong |= along < np.cos(np.radians(TURN)) * np.linalg.norm(normal, axis=1)
    return np.asarray(np.bincount(row[wrong], minlength=len(bad)) == 0, dtype=np.bool_)


def renumbered(net: Net, target: IntArray) -> Net:
    """Return a net with vertices replaced, without the triangles that collapse; what it touches is fresh."""
    triangles = target[net.triangles]
    a, b, c = triangles.T
    whole = (a != b) & (b != c) & (c != a)
    fresh = net.fresh | (triangles != net.triangles).any(axis=1)
    return taken(
        replace(net, triangles=triangles, fresh=np.asarray(fresh, dtype=np.bool_)), np.asarray(whole)
    )
