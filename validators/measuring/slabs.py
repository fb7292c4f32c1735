"""What of segments and triangles lies on other triangles, to a distance: whole arrays, pair by pair."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from graben.arrays import FloatArray, IntArray
from graben.surface import triangle_normals


def unit_normals(corners: FloatArray) -> FloatArray:
    """Return the unit normals of triangles (n, 3, 3), zero where there is no area, shape (n, 3)."""
    flat = corners.reshape(-1, 3)
    normals = triangle_normals(flat, np.arange(len(flat)).reshape(-1, 3))
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(normals / np.where(size > 0, size, 1.0))


@dataclass(frozen=True, eq=False)
class Slabs:
    """What lies on triangles to a distance, as half-spaces that widen with the distance.

    The places within a distance of a triangle are taken as its plane, that thick to either side, cut off
    that far outside each of its sides and beyond the ends of its longest.

    Parameters
    ----------
    outwards : (n, 7, 3) array
        Unit vectors out of the slab.
    limits : (n, 7) array
        Largest products of a place on the triangle with them, model units.
    """

    outwards: FloatArray
    limits: FloatArray

    @classmethod
    def of(cls, corners: FloatArray) -> Slabs:
        """Return the slabs of triangles (n, 3, 3), model units."""
        normals = unit_normals(corners)
        sides = np.roll(corners, -1, axis=1) - corners
        lengths = np.linalg.norm(sides, axis=2)
        along = sides / np.where(lengths > 0, lengths, 1.0)[:, :, None]
        ridge = along[np.arange(len(corners)), np.argmax(lengths, axis=1)]
        outwards = np.stack(
            [
                normals,
                -normals,
                *(np.cross(along[:, k], normals) for k in range(3)),
                ridge,
                -ridge,
            ],
            axis=1,
        )
        return cls(outwards, np.einsum("nki,nci->nkc", outwards, corners).max(axis=2))

    def stretches(
        self, segments: FloatArray, slab: IntArray, reach: float, beside: float | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return which stretch of each segment lies in a slab.

        Parameters
        ----------
        segments : (n, 2, 3) array
            Ends, model units.
        slab : (n,) array
            The slab of each.
        reach : float
            Distance from the triangle, model units.
        beside : float, optional
            Distance outside its sides, where it is another.

        Returns
        -------
        first, last : (n,) arrays
            Share of the segment at which the stretch begins and ends; ``first > last`` where there is none.

        >>> flat = Slabs.of(np.array([[[0.0, 0, 0], [4, 0, 0], [0, 4, 0]]]))
        >>> first, last = flat.stretches(np.array([[[1.0, 1, -1], [1, 1, 1]]]), np.array([0]), 0.5)
        >>> first.tolist(), last.tolist()
        ([0.25], [0.75])
        """
        outwards = self.outwards[slab]
        aside = reach if beside is None else beside
        room = (
            self.limits[slab]
            + np.array([reach] * 2 + [aside] * 5)
            - np.einsum("nki,ni->nk", outwards, segments[:, 0])
        )
        rise = np.einsum("nki,ni->nk", outwards, segments[:, 1] - segments[:, 0])
        meets = room / np.where(rise == 0, 1.0, rise)
        first = np.where(rise < 0, meets, 0.0).max(axis=1, initial=0.0)
        last = np.where(rise > 0, meets, 1.0).min(axis=1, initial=1.0)
        outside = ((rise == 0) & (room < 0)).any(axis=1)
        return first, np.where(outside, -1.0, last)


def merged(
    owner: IntArray, first: FloatArray, last: FloatArray, gap: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the stretches of each owner joined where they overlap.

    Parameters
    ----------
    owner : (n,) array
        Whose stretch it is.
    first, last : (n,) arrays
        Begin and end, in [0, 1], begin not after end.
    gap : (n,) array
        How far apart two stretches of one owner may be that count as one.

    >>> merged(np.zeros(3, int), np.array([0.0, 0.2, 0.7]), np.array([0.3, 0.4, 1]), np.zeros(3))[1].tolist()
    [0.0, 0.7]
    """
    if not len(owner):
        return owner, first, last
    # owners are kept apart by whole numbers, so that one running maximum serves them all
    shift = 4.0 * np.unique(owner, return_inverse=True)[1].reshape(-1)
    order = np.lexsort([first, owner])
    begin, end = (first + shift)[order], (last + shift)[order]
    reached = np.maximum.accumulate(end)
    starts = np.concatenate([[True], begin[1:] > reached[:-1] + np.minimum(gap[order][1:], 1.0)])
    group = np.flatnonzero(starts)
    ends = np.maximum.reduceat(end, group)
    base = shift[order][group]
    return owner[order][group], begin[group] - base, ends - base


def overlaps(
    first: FloatArray, second: FloatArray, reach: float, flatness: float
) -> tuple[IntArray, FloatArray]:
    """Return where triangles lie on each other, as triangles in the planes of the first.

    Parameters
    ----------
    first, second : (n, 3, 3) arrays
        Pairs of triangles.
    reach : float
        Largest distance between them, model units.
    flatness : float
        Sine of the largest angle between their planes.

    Returns
    -------
    pair : (t,) array
        The pair of each.
    corners : (t, 3, 3) array
        Corners, model units.
    """
    na, nb = unit_normals(first), unit_normals(second)
    flat = np.linalg.norm(np.cross(na, nb), axis=1) <= flatness
    flat &= (na != 0).any(axis=1) & (nb != 0).any(axis=1)
    index = np.flatnonzero(flat)
    if not len(index):
        return np.zeros(0, dtype=np.int64), np.zeros((0, 3, 3))
    a, b, normal = first[index], second[index], na[index]
    u = a[:, 1] - a[:, 0]
    u = u / np.linalg.norm(u, axis=1, keepdims=True)
    axes = np.stack([u, np.cross(normal, u)], axis=2)
    local = [(t - a[:, :1]) @ axes for t in (a, b)]
    common = shapely.intersection(*(shapely.polygons(t) for t in local))
    common = np.where(shapely.get_type_id(common) == shapely.GeometryType.POLYGON, common, shapely.Polygon())
    points, ring = shapely.get_coordinates(common, return_index=True)
    places = a[ring, 0] + np.einsum("ij,ikj->ik", points, axes[ring])
    height = np.abs(np.einsum("ij,ij->i", places - b[ring, 0], nb[index][ring]))
    apart = np.zeros(len(index), dtype=bool)
    apart[ring[height > reach]] = True
    head = np.flatnonzero(np.diff(ring, prepend=-1))[np.unique(ring, return_inverse=True)[1].reshape(-1)]
    at = np.arange(len(ring) - 1)
    # a fan about the first point of each convex ring
    fan = at[(ring[:-1] == ring[1:]) & (at > head[:-1]) & ~apart[ring[:-1]]] if len(ring) else at[:0]
    return index[ring[fan]], np.stack([places[head[fan]], places[fan], places[fan + 1]], axis=1)
