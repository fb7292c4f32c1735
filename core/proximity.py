"""The nearest simplex of a mesh to points, in space or in plan."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np

from graben.arrays import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Nearest:
    """The nearest simplex to each of n points.

    ``distance`` (n,) to it, ``simplex`` (n,) its index, ``place`` (n, 2 or 3) the nearest point on it.
    """

    distance: FloatArray
    simplex: IntArray
    place: FloatArray


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
    columns = points.shape[1]
    if len(points) == 0:
        return Nearest(np.zeros(0), np.zeros(0, dtype=np.int64), np.zeros((0, columns)))
    missing = ((0, 0), (0, 3 - columns))
    squared, simplex, place = igl.point_mesh_squared_distance(
        np.ascontiguousarray(np.pad(points, missing)),
        np.ascontiguousarray(np.pad(vertices[:, :columns], missing)),
        np.ascontiguousarray(simplices),
    )
    return Nearest(np.sqrt(squared), np.atleast_1d(simplex), np.atleast_2d(place)[:, :columns])
