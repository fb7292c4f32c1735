"""Fans: the triangles around each vertex that are joined through edges there."""

from __future__ import annotations

import numpy as np

from graben.arrays import FloatArray, IntArray, ints
from graben.surface import edge_sharing, edge_table
from graben.validators.measuring.measures import components


def joints_of(triangles: IntArray) -> IntArray:
    """Return the two sides of each edge with two triangles, as 3 times the triangle and the corner, (q, 2).

    >>> joints_of(ints([[0, 1, 2], [2, 1, 3]])).tolist()
    [[0, 5]]
    """
    edges, sides = edge_table(triangles)
    inner = np.flatnonzero(edge_sharing(sides, len(edges))[sides.ravel()] == 2)
    return inner[np.argsort(sides.ravel()[inner], kind="stable")].reshape(-1, 2)


def fans_of(triangles: IntArray, joints: IntArray) -> IntArray:
    """Return the fan of each corner, shape (m, 3), numbered from 0.

    Two corners are in one fan where their triangles lie around one vertex and are joined, one after the
    other, through sides at it.

    Parameters
    ----------
    triangles : (m, 3) array
        Vertex indices.
    joints : (q, 2) array
        The two sides of each joint, as 3 times the triangle and the corner opposite to the side.

    >>> triangles = ints([[0, 1, 2], [2, 1, 3], [3, 4, 5]])
    >>> len(np.unique(fans_of(triangles, joints_of(triangles))))
    7
    """
    first, second = joints.T
    # the side opposite to corner k runs from corner k + 1 to k + 2, its neighbour the one or the other way
    start, end = (first // 3 * 3 + (first % 3 + step) % 3 for step in (1, 2))
    other = [second // 3 * 3 + (second % 3 + step) % 3 for step in (1, 2)]
    same = triangles.ravel()[start] == triangles.ravel()[other[0]]
    steps = np.concatenate(
        [
            np.stack([start, np.where(same, other[0], other[1])], axis=1),
            np.stack([end, np.where(same, other[1], other[0])], axis=1),
        ]
    )
    return components(triangles.size, steps).reshape(-1, 3)


def crowded_edges(triangles: IntArray) -> IntArray:
    """Return the edges with more than two triangles that have three corners, shape (c, 2).

    >>> crowded_edges(ints([[0, 1, 2], [0, 1, 3], [1, 0, 4]])).tolist()
    [[0, 1]]
    """
    edges, sides = edge_table(_with_three_corners(triangles))
    return ints(edges[edge_sharing(sides, len(edges)) > 2], -1, 2)


def _with_three_corners(t: IntArray) -> IntArray:
    return ints(t[(t[:, 0] != t[:, 1]) & (t[:, 1] != t[:, 2]) & (t[:, 2] != t[:, 0])], -1, 3)


def trouble(triangles: IntArray) -> tuple[int, int]:
    """Return how many edges have more than two triangles, and at how many vertices fans touch in a point.

    Triangles with a corner twice are no part of it.

    >>> trouble(ints([[0, 1, 2], [2, 3, 4]]))
    (0, 1)
    """
    t = _with_three_corners(triangles)
    if not len(t):
        return 0, 0
    crowded = crowded_edges(t)
    one_of_each = np.unique(fans_of(t, joints_of(t)), return_index=True)[1]
    several = np.flatnonzero(np.bincount(t.ravel()[one_of_each]) > 1)
    return len(crowded), len(np.setdiff1d(several, crowded))


def shortest_rim(vertices: FloatArray, rim: IntArray) -> FloatArray:
    """Return the length of the shortest edge of the rim at each vertex, shape (n,); infinite off the rim.

    ``rim`` (b, 2) holds the edges of the rim; lengths are in model units.
    """
    shortest = np.full(len(vertices), np.inf)
    size = np.linalg.norm(vertices[rim[:, 0]] - vertices[rim[:, 1]], axis=1)
    for side in range(2):
        np.minimum.at(shortest, rim[:, side], size)
    return shortest
