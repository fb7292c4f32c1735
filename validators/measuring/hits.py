"""Where straight ways meet the triangles of many surfaces at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from graben.arrays import BoolArray, FloatArray, IntArray, ints
from graben.surface import Surface

#: Share of a triangle's side by which a way may miss it and still meet it, so that none slips between two.
_SEAM = 1e-9

#: Sine of the angle below which a way runs along a triangle and does not cross it.
_GLANCING = 1e-3


@dataclass(frozen=True, eq=False)
class Hits:
    """The first triangle on each of n straight ways.

    ``distance`` (n,) from the start as a share of the way, infinite where nothing is met; ``owner`` (n,) the
    surface that is met, -1 for none.
    """

    distance: FloatArray
    owner: IntArray


class TriangleTree:
    """The triangles of several surfaces, to be asked for those near boxes and on straight ways.

    Parameters
    ----------
    surfaces : sequence of Surface
        Finite coordinates and indices in range.
    """

    def __init__(self, surfaces: Sequence[Surface]) -> None:
        self._count = len(surfaces)
        corners = [s.vertices[s.triangles] for s in surfaces] or [np.zeros((0, 3, 3))]
        self._corners = np.concatenate(corners)
        self._owner = np.repeat(np.arange(len(surfaces)), [len(s.triangles) for s in surfaces])
        self._low, self._high = self._corners.min(axis=1), self._corners.max(axis=1)
        self._tree = shapely.STRtree(_boxes(self._low, self._high))

    def near(self, low: FloatArray, high: FloatArray, apart_from: int) -> BoolArray:
        """Return which boxes (n, 3), (n, 3) meet a triangle's box of which surface, shape (n, surfaces).

        Triangles of surface ``apart_from`` are left out.
        """
        found = np.zeros((len(low), self._count), dtype=np.bool_)
        row, triangle = self._meeting(low, high, apart_from)
        found[row, self._owner[triangle]] = True
        return found

    def first(self, start: FloatArray, way: FloatArray, apart_from: int) -> Hits:
        """Return what straight ways from ``start`` (n, 3) to ``start + way`` meet first.

        Triangles of surface ``apart_from`` are left out. The crossing is that of Möller and Trumbore (Fast,
        minimum storage ray/triangle intersection, 1997), over all pairs of a way and a triangle near it.
        """
        count = len(start)
        distance, owner = np.full(count, np.inf), np.full(count, -1)
        stop = start + way
        row, triangle = self._meeting(np.minimum(start, stop), np.maximum(start, stop), apart_from)
        share = _crossed(start[row], way[row], self._corners[triangle])
        met = np.isfinite(share)
        row, triangle, share = row[met], triangle[met], share[met]
        order = np.lexsort((self._owner[triangle], share, row))
        first = order[np.unique(row[order], return_index=True)[1]]
        distance[row[first]], owner[row[first]] = share[first], self._owner[triangle[first]]
        return Hits(distance, ints(owner))

    def _meeting(self, low: FloatArray, high: FloatArray, apart_from: int) -> tuple[IntArray, IntArray]:
        """Return the pairs of a box and a triangle whose own box meets it."""
        if not len(self._corners) or not len(low):
            return ints([]), ints([])
        row, triangle = self._tree.query(_boxes(low, high))
        met = (self._low[triangle, 2] <= high[row, 2]) & (self._high[triangle, 2] >= low[row, 2])
        met &= self._owner[triangle] != apart_from
        return ints(row[met]), ints(triangle[met])


def _boxes(low: FloatArray, high: FloatArray) -> list[shapely.Geometry]:
    return shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1])  # type: ignore[no-any-return]


def _crossed(start: FloatArray, way: FloatArray, corners: FloatArray) -> FloatArray:
    """Return the share of each way at which it crosses its triangle; infinite where it does not."""
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    side = np.cross(way, two)
    volume = np.einsum("ij,ij->i", one, side)
    size = np.linalg.norm(way, axis=1) * np.linalg.norm(np.cross(one, two), axis=1)
    flat = np.abs(volume) <= _GLANCING * size
    scale = 1.0 / np.where(flat, 1.0, volume)
    offset = start - corners[:, 0]
    u = np.einsum("ij,ij->i", offset, side) * scale
    other = np.cross(offset, one)
    v = np.einsum("ij,ij->i", way, other) * scale
    share = np.einsum("ij,ij->i", two, other) * scale
    inside = (u >= -_SEAM) & (v >= -_SEAM) & (u + v <= 1 + _SEAM) & (share >= 0) & (share <= 1)
    return np.where(inside & ~flat, share, np.inf)
