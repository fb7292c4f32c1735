"""What is near what: the nearest simplex to points, and boxes that meet."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
import shapely

from graben.arrays import FloatArray, IntArray


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
