"""The lines in which the surfaces of a complex meet, and the parts into which they cut each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, ints
from graben.complexes import Complex
from graben.proximity import nearest
from graben.validators.measuring.measures import components


@dataclass(frozen=True, eq=False)
class OnBranch:
    """The nearest place on a branch line to each of n points.

    ``distance`` (n,), infinite where the two surfaces share no edge; ``place`` (n, 3); ``end`` (n,) where it
    is an end of the line.
    """

    distance: FloatArray
    place: FloatArray
    end: BoolArray


class BranchLines:
    """The edges that two surfaces of a complex share.

    Parameters
    ----------
    network : Complex
        Surfaces refined along their intersections.
    contact : float
        Distance at which two places are one, model units.
    """

    def __init__(self, network: Complex, contact: float) -> None:
        self._network = network
        self._contact = contact
        self._edges, self._sides = network.edges()
        self._shared: dict[tuple[int, int], IntArray] = {}
        for a, b, edge in _by_pair(self._sides, network.owner):
            self._shared[a, b] = self._shared[b, a] = edge

    def nearest(self, points: FloatArray, own: int, other: int) -> OnBranch:
        """Return the nearest places on the branch line of two surfaces to points (n, 3)."""
        shared = self._shared.get((own, other))
        if shared is None:
            return OnBranch(np.full(len(points), np.inf), points, np.zeros(len(points), dtype=bool))
        edges, vertices = self._edges[shared], self._network.vertices
        found = nearest(points, vertices, edges)
        used, count = np.unique(edges, return_counts=True)
        # exact intersections end in edges shorter than any rounding, so an end is a place, not an edge
        ends = vertices[used[count == 1]]
        end = np.zeros(len(points), dtype=bool)
        if len(ends):
            end = cKDTree(ends).query(found.place)[0] <= self._contact
        return OnBranch(found.distance, found.place, end)

    def parts(self, own: int, other: int) -> IntArray:
        """Return the part of one surface that each triangle of the complex lies in, cut along another.

        Shape (m,); -1 for triangles of other surfaces. Parts are joined through edges.
        """
        mine = np.flatnonzero(self._network.owner == own)
        edges, side = np.unique(self._sides[mine], return_inverse=True)
        joined = ~np.isin(edges, self._shared.get((own, other), ints([])))[side].ravel()
        pairs = np.stack([np.repeat(np.arange(len(mine)), 3), len(mine) + side.ravel()], axis=1)[joined]
        part = np.full(len(self._network.triangles), -1)
        part[mine] = components(len(mine) + len(edges), pairs)[: len(mine)]
        return ints(part)


def _by_pair(sides: IntArray, owner: IntArray) -> list[tuple[int, int, IntArray]]:
    """Return the edges that each pair of owners shares."""
    count = int(owner.max(initial=0)) + 1
    uses = np.stack(np.divmod(np.unique(sides.ravel() * count + np.repeat(owner, 3)), count), axis=1)
    rows = [np.zeros((0, 3), dtype=np.int64)]
    apart = 1
    while apart < len(uses) and (same := uses[apart:, 0] == uses[:-apart, 0]).any():
        rows.append(np.column_stack([uses[:-apart, 1][same], uses[apart:, 1][same], uses[apart:, 0][same]]))
        apart += 1
    table = np.concatenate(rows)
    table = table[np.lexsort(table.T[::-1])]
    starts = np.flatnonzero(np.diff(table[:, :2], axis=0).any(axis=1)) + 1
    return [(int(t[0, 0]), int(t[0, 1]), ints(t[:, 2])) for t in np.split(table, starts) if len(t)]
