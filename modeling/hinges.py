"""Which angles, edges and triangles of a triangulation belong to each edge with two triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import IntArray, ints
from graben.errors import ModelingError
from graben.surface import edge_sharing


@dataclass(frozen=True, eq=False)
class Hinges:
    """The edges with two triangles, and how edges and angles find each other through them.

    An angle is numbered 3 t + c, c the corner of triangle t; m triangles, e edges, q hinges.

    Parameters
    ----------
    nodes : (4, q) array
        Nodes i, j, k, l of each edge ij with two triangles, k and l opposite.
    edges : (q,) array
        The edge ij of each.
    faces : (2, q) array
        Its triangles ijk and ijl.
    angles : (4, q) array
        Its angles at i and j in the first triangle, then at i and j in the second.
    opposite : (2, e) array
        The angles opposite to each edge; 3 m for the one that an edge with one triangle lacks.
    rims : (4, e) array
        Where an edge is ik, jk, il or jl (0 to 3) of hinge h: 0 to 3 times q, plus h; 4 q for nowhere.
    """

    nodes: IntArray
    edges: IntArray
    faces: IntArray
    angles: IntArray
    opposite: IntArray
    rims: IntArray

    @staticmethod
    def of(triangles: IntArray, edges: IntArray, sides: IntArray) -> Hinges:
        """Return the hinges of a triangulation (m, 3) whose table of edges is (e, 2) and (m, 3).

        Raises
        ------
        ModelingError
            When an edge has more than two triangles.
        """
        sharing = edge_sharing(sides, len(edges))
        if len(sharing) and sharing.max() > 2:
            a, b = edges[int(np.argmax(sharing))]
            raise ModelingError(f"More than two triangles share the edge between nodes {a} and {b}.")
        order = np.argsort(sides.ravel(), kind="stable")
        first = np.concatenate([[0], np.cumsum(sharing)])[:-1]
        inner = np.flatnonzero(sharing == 2)
        opposite = np.full((2, len(edges)), triangles.size)
        opposite[0], opposite[1, inner] = order[first], order[first[inner] + 1]
        after, before = _neighbours(triangles)
        angles, start = [], edges[inner, 0]
        for corner in opposite[:, inner]:
            forward = triangles.ravel()[after[corner]] == start
            angles += [
                np.where(forward, after[corner], before[corner]),
                np.where(forward, before[corner], after[corner]),
            ]
        nodes = np.concatenate([edges[inner].T, triangles.ravel()[opposite[:, inner]]])
        return Hinges(
            ints(nodes),
            ints(inner),
            ints(opposite[:, inner] // 3),
            ints(angles, 4, -1),
            ints(opposite),
            _rims(triangles, edges, sides, opposite, inner),
        )


def _neighbours(triangles: IntArray) -> tuple[IntArray, IntArray]:
    """Return for each angle the next one and the one before in its triangle, (3 m,) each."""
    numbers = np.arange(triangles.size).reshape(-1, 3)
    return numbers[:, [1, 2, 0]].ravel(), numbers[:, [2, 0, 1]].ravel()


def _rims(
    triangles: IntArray, edges: IntArray, sides: IntArray, opposite: IntArray, inner: IntArray
) -> IntArray:
    """Return where each edge lies on the rim of a hinge, (4, e): twice in each of its triangles."""
    count = len(inner)
    hinge = np.full(len(edges), -1)
    hinge[inner] = np.arange(count)
    rims = np.full((4, len(edges)), 4 * count)
    after, before = _neighbours(triangles)
    for side in range(2):
        there = np.flatnonzero(opposite[side] < triangles.size)
        corner = opposite[side, there]
        # The other two sides of the triangle, each with the node that it shares with the edge.
        for place, (across, shared) in enumerate(
            ((after[corner], before[corner]), (before[corner], after[corner]))
        ):
            other = sides.ravel()[across]
            role = 2 * (opposite[1, other] == across) + (edges[other, 0] != triangles.ravel()[shared])
            rims[2 * side + place, there] = np.where(
                hinge[other] >= 0, role * count + hinge[other], 4 * count
            )
    return ints(rims)
