"""Measures of triangles that several checks share, over whole arrays."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from graben.arrays import FloatArray, IntArray
from graben.surface import Surface, triangle_areas

#: Height over the longest side below which a triangle counts as having no area: above the rounding of
#: coordinates of hundreds of kilometres (1e-11 of a side of metres), far below any sliver.
ZERO_HEIGHT = 1e-9


def side_lengths(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Return the length of the side opposite to each corner, shape (m, 3), model units."""
    corners = vertices[triangles]
    return np.asarray(np.linalg.norm(corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]], axis=2))


def smallest_angles(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Return the smallest angle of each triangle, shape (m,), degrees; 0 where there is no area."""
    sides = np.sort(side_lengths(vertices, triangles), axis=1)
    double_area = 2.0 * triangle_areas(vertices, triangles)
    longest = np.where(sides[:, 2] > 0, sides[:, 2], 1.0)
    flat = double_area <= ZERO_HEIGHT * longest * longest
    # the smallest angle lies between the two longer sides: its sine is 2 A / (b c), its cosine is positive
    product = np.where(flat, 1.0, sides[:, 1] * sides[:, 2])
    angles = np.degrees(np.arcsin(np.clip(double_area / product, 0.0, 1.0)))
    return np.asarray(np.where(flat, 0.0, angles), dtype=np.float64)


def centroids(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Return the centroids of triangles, shape (m, 3), model units."""
    return np.asarray(vertices[triangles].mean(axis=1), dtype=np.float64).reshape(-1, 3)


def with_three_corners(surface: Surface) -> IntArray:
    """Return the indices of the triangles whose three vertex indices differ, shape (k,)."""
    t = surface.triangles
    return np.flatnonzero((t[:, 0] != t[:, 1]) & (t[:, 1] != t[:, 2]) & (t[:, 2] != t[:, 0]))


def components(count: int, pairs: IntArray) -> IntArray:
    """Return the connected component of each of ``count`` items joined by ``pairs`` (p, 2)."""
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


def plural(count: int, word: str, many: str = "") -> str:
    """Return a count with its word, as in ``1 triangle`` or ``3 vertices``."""
    return f"{count} {word if count == 1 else many or word + 's'}"
