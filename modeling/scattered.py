"""Scattered picks on a triangulation: the least-squares problem of the values of its nodes.

The values u of the nodes minimize

    1/2 sum over picks of a_p (u(p) - z_p)^2 + c^4 E_H(u),

u(p) the linear interpolation in the triangle of pick p, a_p the area that pick p stands for, E_H the
Hessian-like energy of :mod:`graben.modeling.energy` and c the length over which the picks are smoothed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats, ints
from graben.modeling.energy import EdgePattern, assemble
from graben.proximity import nearest

#: Points closer in plan than this share of the step are one.
SAME_PLACE = 1e-6


@dataclass(frozen=True, eq=False)
class Places:
    """Picks by place: plan positions in steps (k, 2), mean elevations and numbers of picks (k,).

    ``spread`` (k,) is the sum of squares of the picks about the mean of their place, ``which`` (p,) the
    place of each pick.
    """

    points: FloatArray
    means: FloatArray
    counts: FloatArray
    spread: FloatArray
    which: IntArray

    @staticmethod
    def of(local: FloatArray, z: FloatArray) -> Places:
        """Return the places of picks at plan positions (p, 2), in steps, with elevations (p,)."""
        keys = np.round(local / SAME_PLACE).astype(np.int64)
        which = np.unique(keys, axis=0, return_inverse=True)[1].ravel()
        counts = np.bincount(which).astype(np.float64)
        points = np.stack([np.bincount(which, local[:, c]) / counts for c in range(2)], axis=1)
        means = np.bincount(which, z) / counts
        spread = np.bincount(which, (z - means[which]) ** 2)
        return Places(floats(points), floats(means), floats(counts), floats(spread), ints(which))


@dataclass(frozen=True, eq=False)
class Scattered:
    """The problem of places on a mesh, in steps; its matrices share one pattern.

    ``corners`` (k, 3) are the nodes of the triangle of each place and ``weights`` (k, 3) their shares in its
    value, ``shares`` (k,) the areas a_p; ``data`` and ``energy`` the matrices of the two terms, (n, n).
    """

    corners: IntArray
    weights: FloatArray
    shares: FloatArray
    data: csc_array
    energy: csc_array

    @staticmethod
    def of(
        points: FloatArray, triangles: IntArray, faces: IntArray, weights: FloatArray, shares: FloatArray
    ) -> Scattered:
        """Set up the problem of places in the triangles ``faces`` (k,), barycentric ``weights`` (k, 3)."""
        pattern = EdgePattern.of(triangles, len(points))
        corners, sides = triangles[faces], pattern.side_slots[faces]
        diagonal, pairs = np.zeros(len(points)), np.zeros(pattern.pair_count)
        for c in range(3):
            own = shares * weights[:, c] ** 2
            beside = shares * weights[:, (c + 1) % 3] * weights[:, (c + 2) % 3]
            diagonal += np.bincount(corners[:, c], own, minlength=len(diagonal))
            pairs += np.bincount(sides[:, c], beside, minlength=len(pairs))
        energy = assemble(points, pattern, theta=1.0, length=1.0)
        return Scattered(
            ints(corners), floats(weights), floats(shares), pattern.matrix(diagonal, pairs), energy
        )

    def matrix(self, smoothing: float) -> csc_array:
        """Return the matrix for a length c, in steps."""
        result = self.energy.copy()
        result.data = self.data.data + smoothing**4 * self.energy.data
        return result

    def load(self, values: FloatArray) -> FloatArray:
        """Return the right side of the equations for values at the places, (k,)."""
        told = (self.shares * values)[:, None] * self.weights
        return floats(np.bincount(self.corners.ravel(), told.ravel(), minlength=self.data.shape[0]))

    def at_places(self, nodes: FloatArray) -> FloatArray:
        """Return the surface's values at the places, (k,)."""
        return floats((nodes[self.corners] * self.weights).sum(axis=1))


def located(
    points: FloatArray, triangles: IntArray, places: FloatArray
) -> tuple[IntArray, FloatArray, BoolArray]:
    """Return the triangle of each place, its barycentric coordinates there, and whether it lies inside.

    All in steps: ``points`` (n, 2), ``triangles`` (m, 3), ``places`` (k, 2).
    """
    near = nearest(places[:, :2], points, triangles)
    faces = near.simplex
    a, b, c = (points[triangles[faces, k]] for k in range(3))
    double_area = _cross(b - a, c - a)
    weight_a = _cross(b - places, c - places) / double_area
    weight_b = _cross(c - places, a - places) / double_area
    weights = np.stack([weight_a, weight_b, 1.0 - weight_a - weight_b], axis=1)
    return ints(faces), floats(weights), bools(near.distance <= SAME_PLACE)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], dtype=np.float64)
