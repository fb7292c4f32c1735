"""The cells into which the sheets of a complex part space."""

from __future__ import annotations

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.refinement import component_labels
from graben.surface import edge_sharing, edge_table

#: Turns less clear than this share of the size are rounding. Clear is the angle in radians times the height
#: of the narrower triangle; branch lines have 1e-5 and more, rounding of 5000 km is 1e-9 of a km.
_UNCLEAR = 1e-9


def cells(vertices: FloatArray, triangles: IntArray) -> IntArray:
    """Return the cell on each side of each triangle, (m, 2): in front, where its normal points, and behind.

    Two sides of triangles are of one cell where one comes from the one to the other round an edge. About an
    edge of two triangles that is so whatever their angle; about one of more, the angles say which sides face
    each other. Along a branch line they must say the same everywhere, so that they are read at one edge only:
    that where the triangles are widest and their angles differ most, since next to slivers, which exact
    intersection leaves, rounding makes angles of any size. A line of slivers only is not read: what it would
    say follows from other lines, or the cells do not close. (igl's
    ``extract_cells`` reads every edge, stops at a triangle without area, and gave cells that miss 5 % of a
    box parted by a main and a splay in right angles, a case of the tests.)

    Parameters
    ----------
    vertices : (n, 3) array
        Model units.
    triangles : (m, 3) array
        Each once; they meet in shared vertices and edges only. They may turn either way.

    Returns
    -------
    (m, 2) array
        Numbers from 0. Parts of the complex that have no edge in common know nothing of each other: each
        has an outer cell of its own.

    Examples
    --------
    >>> corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    >>> cells(corners, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])).tolist()
    [[0, 1], [0, 1], [0, 1], [0, 1]]
    """
    edges, sides = edge_table(triangles)
    share = edge_sharing(sides, len(edges))
    start = triangles[:, [1, 2, 0]]
    along = (start == edges[sides, 0]).ravel()  # whether the triangle runs along the edge as the edge does
    edge, triangle = sides.ravel(), np.repeat(np.arange(len(triangles)), 3)

    two = np.flatnonzero(share[edge] == 2)
    plain = two[np.argsort(edge[two], kind="stable")].reshape(-1, 2)
    joined = [_facing(triangle[plain], along[plain], same) for same in (True, False)]

    many = np.flatnonzero(share[edge] > 2)
    if len(many):
        opposite = triangles.ravel()[many]
        angle, width = _angles(vertices, edges[edge[many]], opposite)
        order = np.lexsort([angle, edge[many]])
        many, angle, width = many[order], angle[order], width[order]
        after = _next_in_group(edge[many])
        gap = np.where(after > np.arange(len(many)), 0.0, 2.0 * np.pi) + angle[after] - angle
        clearness = np.minimum(gap, np.pi) * np.minimum(width, width[after])
        least = _UNCLEAR * float(np.linalg.norm(np.ptp(vertices, axis=0)))
        read = np.isin(edge[many], _clearest(edges, edge[many], clearness, least))
        turn = np.stack([many, many[after]], axis=1)[read]
        joined.append(_facing(triangle[turn], along[turn], True))
    single = np.flatnonzero(share[edge] == 1)
    joined.append(2 * triangle[single][:, None] + np.array([0, 1]))
    return component_labels(2 * len(triangles), np.concatenate(joined)).reshape(-1, 2)


def _facing(triangles: IntArray, along: BoolArray, forward: bool) -> IntArray:
    """Return which sides of pairs of triangles (p, 2) face each other over their edge; side 2 t is t's front.

    The first triangle is left by its side ahead, seen as turning round the edge counter-clockwise, the next
    entered by its side behind; with ``forward`` false the other way round. The front of a triangle that runs
    along the edge is ahead.
    """
    ahead = along == np.array([forward, not forward])
    return np.asarray(2 * triangles + ~ahead, dtype=np.int64)


def _angles(vertices: FloatArray, ends: IntArray, opposite: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the angle of each triangle about its edge, counter-clockwise, and its height over it."""
    origin = vertices[ends[:, 0]]
    axis = vertices[ends[:, 1]] - origin
    axis /= np.maximum(np.linalg.norm(axis, axis=1), np.finfo(float).tiny)[:, None]
    across = np.eye(3)[np.abs(axis).argmin(axis=1)]
    first = np.cross(axis, across)
    first /= np.linalg.norm(first, axis=1)[:, None]
    out = vertices[opposite] - origin
    x = np.einsum("ij,ij->i", out, first)
    y = np.einsum("ij,ij->i", out, np.cross(axis, first))
    return np.arctan2(y, x), np.hypot(x, y)


def _next_in_group(group: IntArray) -> IntArray:
    """Return the place of the next member of the same group, the first after the last; groups are sorted."""
    first = np.concatenate([[True], group[1:] != group[:-1]])
    start = np.flatnonzero(first)
    after = np.arange(1, len(group) + 1)
    after[np.append(start[1:], len(group)) - 1] = start
    return after


def _clearest(edges: IntArray, edge: IntArray, clearness: FloatArray, enough: float) -> IntArray:
    """Return an edge of each branch line: that whose least clear turn is the clearest, where it is enough.

    Parameters
    ----------
    edges : (e, 2) array
        Vertex indices of all edges.
    edge, clearness : (q,) arrays
        Edge of each turn from a triangle to the next, and how clear it is; sorted by edge.
    """
    lines, first = np.unique(edge, return_index=True)
    least = np.minimum.reduceat(clearness, first)
    ends = edges[lines]
    degree = np.bincount(ends.ravel())
    at = np.argsort(ends.ravel(), kind="stable")
    vertex = ends.ravel()[at]
    on = np.flatnonzero((vertex[1:] == vertex[:-1]) & (degree[vertex[1:]] == 2))
    line = component_labels(len(lines), np.stack([at[on], at[on + 1]], axis=1) // 2)
    order = np.argsort(least, kind="stable")
    best = np.zeros(int(line.max()) + 1, dtype=np.int64)
    best[line[order]] = order
    return lines[best[least[best] > enough]]
