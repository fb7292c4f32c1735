"""What is near what: the nearest simplex to points, and boxes that meet."""

from __future__ import annotations

import math
from dataclasses import dataclass

import igl
import numpy as np
import shapely

from graben.arrays import BoolArray, FloatArray, IntArray

#: Points that a cell of :class:`PlanIndex` has in the mean: fewer cells cost less to walk through.
_IN_CELL = 64


@dataclass(frozen=True, eq=False)
class Nearest:
    """The nearest simplex to each of n points.

    ``distance`` (n,) to it, ``simplex`` (n,) its index, ``place`` (n, 2 or 3) the nearest point on it.
    """

    distance: FloatArray
    simplex: IntArray
    place: FloatArray


class Simplices:
    """Edges or triangles that are asked again and again for the nearest of them to points.

    Parameters
    ----------
    vertices : (v, 2) or (v, 3) array
        Of two columns only x and y are asked for, model units.
    simplices : (s, 2) or (s, 3) array
        Vertex indices of edges or triangles, at least one.
    """

    def __init__(self, vertices: FloatArray, simplices: IntArray) -> None:
        self._vertices = _in_space(vertices)
        self._simplices = np.ascontiguousarray(simplices)
        self._tree = igl.AABB()
        self._tree.init(self._vertices, self._simplices)

    def nearest(self, points: FloatArray) -> Nearest:
        """Return the nearest of them to each point (n, 2) or (n, 3), as :func:`nearest` does."""
        columns = points.shape[1]
        if len(points) == 0:
            return Nearest(np.zeros(0), np.zeros(0, dtype=np.int64), np.zeros((0, columns)))
        squared, simplex, place = self._tree.squared_distance(
            self._vertices, self._simplices, _in_space(points)
        )
        return Nearest(np.sqrt(squared), np.atleast_1d(simplex), np.atleast_2d(place)[:, :columns])


def nearest(points: FloatArray, vertices: FloatArray, simplices: IntArray) -> Nearest:
    """Return the nearest edge or triangle to each point.

    Parameters
    ----------
    points : (n, 2) or (n, 3) array
        With two columns the question is asked in plan, model units.
    vertices : (v, 2) or (v, 3) array
        In plan only x and y count.
    simplices : (s, 2) or (s, 3) array
        Vertex indices of edges or triangles, at least one.

    >>> corners = np.array([[0.0, 0, 5], [2, 0, 5], [0, 2, 5]])
    >>> nearest(np.array([[3.0, 0.0]]), corners, np.array([[0, 1, 2]])).distance.tolist()
    [1.0]
    """
    if len(points) == 0:
        columns = points.shape[1]
        return Nearest(np.zeros(0), np.zeros(0, dtype=np.int64), np.zeros((0, columns)))
    return Simplices(vertices[:, : points.shape[1]], simplices).nearest(points)


class PlanIndex:
    """Points that are asked again and again which of them lie in a box of the plan.

    Parameters
    ----------
    points : (n, 2) or (n, 3) array
        Model units; those that are not finite lie in no box.
    """

    def __init__(self, points: FloatArray) -> None:
        self.points = points
        plan = points[:, :2]
        fit = np.flatnonzero(np.isfinite(plan).all(axis=1))
        plan = plan[fit]
        self._low = plan.min(axis=0) if len(fit) else np.zeros(2)
        high = plan.max(axis=0) if len(fit) else np.zeros(2)
        self._count = math.isqrt(len(fit) // _IN_CELL) + 1
        self._cell = np.where(high > self._low, (high - self._low) / self._count, 1.0)
        i, j = self._cells(plan)
        key = i * self._count + j
        self._order = fit[np.argsort(key, kind="stable")]
        self._starts = np.append(0, np.cumsum(np.bincount(key, minlength=self._count**2)))

    def within(self, low: FloatArray, high: FloatArray) -> IntArray:
        """Return which points lie in the box between two corners (2,), sides included, ascending.

        >>> index = PlanIndex(np.array([[0.0, 0], [1, 1], [2, 2], [3, 3]]))
        >>> index.within(np.ones(2), np.full(2, 2.5)).tolist()
        [1, 2]
        """
        (i, i_end), (j, j_end) = self._cells(np.stack([low, high]))
        columns = np.arange(i, i_end + 1) * self._count
        parts = [self._order[self._starts[c + j] : self._starts[c + j_end + 1]] for c in columns.tolist()]
        found = np.sort(np.concatenate([self._order[:0], *parts]))
        plan = self.points[found, :2]
        return found[((plan >= low) & (plan <= high)).all(axis=1)]

    def _cells(self, plan: FloatArray) -> tuple[IntArray, IntArray]:
        """Return column and row of the cell of each place (k, 2), the nearest for one outside."""
        i, j = np.clip((plan - self._low) / self._cell, 0, self._count - 1).astype(np.int64).T
        return i, j


def _in_space(points: FloatArray) -> FloatArray:
    """Return points with three columns, in one block of memory."""
    if points.shape[1] < 3:
        points = np.pad(points, ((0, 0), (0, 3 - points.shape[1])))
    return np.ascontiguousarray(points)


def boxes(vertices: FloatArray, triangles: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the least and greatest corners of the bounding boxes of triangles, shapes (m, 3).

    Parameters
    ----------
    vertices : (v, 3) array
        Model units.
    triangles : (m, 3) array
        Vertex indices.
    """
    # corner by corner: several times as fast as min and max along an axis of three
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    low = np.minimum(np.minimum(a, b), c)
    return low, np.maximum(np.maximum(a, b), c)


def boxes_over(low: FloatArray, high: FloatArray, other_low: FloatArray, other_high: FloatArray) -> BoolArray:
    """Return which boxes may meet one of some others in plan, (n,); those left out certainly do not.

    On a raster over the others: much faster than a tree where most boxes are far from all of them.

    Parameters
    ----------
    low, high : (n, 2 or 3) arrays
        Least and greatest corners; of points the same array twice.
    other_low, other_high : (k, 2 or 3) arrays
        Those of the others.

    >>> low = np.array([[0.0, 0], [5, 5], [9, 9]])
    >>> boxes_over(low, low + 1, low[1:2], low[1:2] + 1).tolist()
    [False, True, False]
    """
    if not len(low) or not len(other_low):
        return np.zeros(len(low), dtype=bool)
    start, end = other_low[:, :2].min(axis=0), other_high[:, :2].max(axis=0)
    # as many cells as boxes: what the raster costs is of the order of what the boxes do
    count = math.isqrt(len(low) + len(other_low)) + 1
    cell = np.where(end > start, (end - start) / count, 1.0)

    def places(corners: FloatArray) -> tuple[IntArray, IntArray]:
        i, j = np.clip((corners[:, :2] - start) / cell, -1.0, count).astype(np.int64).T
        return i, j

    (i, j), (i_end, j_end) = places(other_low), places(other_high)
    # each box adds one from its first cell on and takes it away after its last
    size = count + 2
    change = np.zeros((size, size), dtype=np.int64)
    for u, v, sign in ((i, j, 1), (i_end + 1, j, -1), (i, j_end + 1, -1), (i_end + 1, j_end + 1, 1)):
        change += sign * np.bincount(u * size + v, minlength=size * size).reshape(size, size)
    covered = change.cumsum(axis=0).cumsum(axis=1) > 0
    beyond = (high[:, 0] < start[0]) | (high[:, 1] < start[1]) | (low[:, 0] > end[0]) | (low[:, 1] > end[1])
    if low is high:
        i, j = (np.maximum(p, 0) for p in places(low))
        return np.asarray(covered[i, j] & ~beyond, dtype=bool)
    total = np.zeros((size + 1, size + 1), dtype=np.int64)
    total[1:, 1:] = covered.cumsum(axis=0).cumsum(axis=1)
    i, j, i_end, j_end = (np.maximum(p, 0) for corners in (low, high) for p in places(corners))
    within = total[i_end + 1, j_end + 1] - total[i, j_end + 1] - total[i_end + 1, j] + total[i, j]
    return np.asarray((within > 0) & ~beyond, dtype=bool)


def box_pairs(
    low_a: FloatArray, high_a: FloatArray, low_b: FloatArray, high_b: FloatArray, along: int = 2
) -> IntArray:
    """Return the pairs (i, j) of boxes of two sets that meet, shape (p, 2).

    Parameters
    ----------
    low_a, high_a, low_b, high_b : (n, 3) arrays
        Least and greatest corners of the boxes.
    along : int
        Axis that is looked at last: the one along which most boxes lie behind each other.

    >>> unit = np.ones((1, 3))
    >>> box_pairs(0 * unit, unit, np.array([[1.0, 1, 1], [2, 0, 0]]), np.full((2, 3), 3.0)).tolist()
    [[0, 0]]
    """
    if not len(low_a) or not len(low_b):
        return np.zeros((0, 2), dtype=np.int64)
    u, v = (k for k in range(3) if k != along)
    tree = shapely.STRtree(shapely.box(low_b[:, u], low_b[:, v], high_b[:, u], high_b[:, v]))
    a, b = tree.query(shapely.box(low_a[:, u], low_a[:, v], high_a[:, u], high_a[:, v]))
    # the tree gives every pair of its two axes that meets; the third decides
    meet = (low_a[a, along] <= high_b[b, along]) & (low_b[b, along] <= high_a[a, along])
    return np.stack([a[meet], b[meet]], axis=1).astype(np.int64)
