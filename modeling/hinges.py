"""Which nodes and edges belong to each edge with two triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graben.arrays import IntArray, ints
from graben.errors import ModelingError
from graben.surface import edge_sharing


@dataclass(frozen=True, eq=False)
class Hinges:
    """The q edges with two triangles.

    Parameters
    ----------
    nodes : (q, 4) array
        Nodes i, j, k, l of each edge ij with two triangles, k and l opposite.
    edges : (q, 5) array
        The edges ij, ik, jk, il, jl.
    """

    nodes: IntArray
    edges: IntArray

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
        i, j = edges[inner].T
        tips, around = [], []
        for corner in (order[first[inner]], order[first[inner] + 1]):
            face, place = corner // 3, corner % 3
            after, before = (place + 1) % 3, (place + 2) % 3
            forward = triangles[face, after] == i
            tips.append(triangles[face, place])
            # The side at i lies opposite to j, and the other way round.
            around.append(sides[face, np.where(forward, before, after)])
            around.append(sides[face, np.where(forward, after, before)])
        return Hinges(ints(np.stack([i, j, *tips], axis=1)), ints(np.stack([inner, *around], axis=1)))
