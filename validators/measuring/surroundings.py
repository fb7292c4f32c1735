"""How two surfaces lie around a line that both hold: which passes through, which ends, which folds back."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, ints
from graben.proximity import box_pairs, nearest
from graben.validators.measuring.slabs import Slabs, unit_normals

#: Radius at which the surfaces are looked at around a line, in contact distances over the sine of the angle
#: that they make: there they are as many contact distances apart. That sine is not taken below the least.
_RING, _LEAST_SINE = 4.0, 0.01
#: Angle between two directions of a surface below which they are one, radians.
_ONE_WAY = 0.1
#: Rounds in which a place where a surface passes the ring is sought, and how near it must come to one, radii.
_ROUNDS, _ON_RING = 4, 0.1
#: How far the ring reaches at most, in contact distances.
WIDEST = _RING / _LEAST_SINE


class Meeting(IntEnum):
    """How two surfaces meet along a segment."""

    THROUGH = 0  #: each lies on both sides of the other
    BACK = 1  #: both go on, on the same side of each other
    FIRST_ENDS = 2  #: the first ends there
    SECOND_ENDS = 3  #: the second ends there
    BOTH_END = 4


@dataclass(frozen=True, eq=False)
class Facets:
    """Triangles of a surface: corners (m, 3, 3), unit normals (m, 3), boxes (m, 3) low and high.

    ``index`` (m,) numbers them in the surface; triangles without area are left out.
    """

    corners: FloatArray
    normals: FloatArray
    low: FloatArray
    high: FloatArray
    index: IntArray

    @classmethod
    def made(cls, vertices: FloatArray, triangles: IntArray) -> Facets:
        """Return the facets of a surface."""
        corners = vertices[triangles].reshape(-1, 3, 3)
        normals = unit_normals(corners)
        index = np.flatnonzero((normals != 0).any(axis=1))
        corners = corners[index]
        return cls(corners, normals[index], corners.min(axis=1), corners.max(axis=1), index)

    def within(self, low: FloatArray, high: FloatArray) -> Facets:
        """Return those whose boxes meet a box, (3,) low and high."""
        return self.of(np.flatnonzero((self.high >= low).all(axis=1) & (self.low <= high).all(axis=1)))

    def of(self, at: IntArray) -> Facets:
        """Return some of them."""
        return Facets(self.corners[at], self.normals[at], self.low[at], self.high[at], self.index[at])

    @cached_property
    def slabs(self) -> Slabs:
        """What lies on each to a distance."""
        return Slabs.of(self.corners)

    @property
    def along(self) -> int:
        """The axis that most of the area faces."""
        a, b, c = (self.corners[:, k] for k in range(3))
        return int(np.argmax(np.abs(np.cross(b - a, c - a)).sum(axis=0)))

    def near(self, points: FloatArray, reach: float) -> tuple[IntArray, IntArray]:
        """Return the pairs (point, facet) that lie within ``reach`` of each other."""
        p, t = box_pairs(points - reach, points + reach, self.low, self.high, self.along).T
        first, last = self.slabs.stretches(np.stack([points[p]] * 2, axis=1), t, reach)
        return p[first <= last], t[first <= last]


def meetings(
    segments: FloatArray, one: Facets, other: Facets, tolerance: float
) -> tuple[IntArray, FloatArray]:
    """Return how two surfaces meet along segments that lie on both.

    A surface is looked at in the plane across the segment's middle, on a ring wide compared with the
    tolerance: where it passes the ring, there it goes on. With one such way it ends at the segment. Two
    surfaces with two ways each pass through one another when their ways alternate around the ring.

    Parameters
    ----------
    segments : (n, 2, 3) array
        Ends, model units; none without length.
    one, other : Facets
        The surfaces.
    tolerance : float
        Distance at which two surfaces touch, model units.

    Returns
    -------
    meeting : (n,) array
        :class:`Meeting` of each.
    radius : (n,) array
        Of the ring about each, model units.
    """
    middles = segments.mean(axis=1)
    way = segments[:, 1] - segments[:, 0]
    way = way / np.linalg.norm(way, axis=1, keepdims=True)
    radius = _radii(middles, one, other, tolerance)
    ways = [_ways(middles, way, radius, facets) for facets in (one, other)]
    (a1, a2, goes_on), (b1, b2, other_goes_on) = ways
    inside = [(a - b1) % (2 * np.pi) < (b2 - b1) % (2 * np.pi) for a in (a1, a2)]
    result = np.where(inside[0] != inside[1], Meeting.THROUGH, Meeting.BACK)
    result[~goes_on] = Meeting.FIRST_ENDS
    result[~other_goes_on] = Meeting.SECOND_ENDS
    result[~goes_on & ~other_goes_on] = Meeting.BOTH_END
    return ints(result), radius


def _radii(middles: FloatArray, one: Facets, other: Facets, tolerance: float) -> FloatArray:
    """Return the radius of the ring about each segment, wider where the surfaces make a small angle."""
    a = nearest_facets(middles, one)
    b = nearest_facets(middles, other)
    sine = np.linalg.norm(np.cross(one.normals[a], other.normals[b]), axis=1)
    return np.asarray(_RING / np.maximum(sine, _LEAST_SINE) * tolerance)


def nearest_facets(points: FloatArray, facets: Facets) -> IntArray:
    """Return the nearest facet of each point, (n,)."""
    return np.asarray(_nearest(points, facets)[1])


def _nearest(points: FloatArray, facets: Facets) -> tuple[FloatArray, IntArray]:
    """Return the nearest place of a surface to each point, (n, 3), and its facet."""
    flat = facets.corners.reshape(-1, 3)
    found = nearest(points, flat, np.arange(len(flat)).reshape(-1, 3))
    return found.place, found.simplex


def _ways(
    middles: FloatArray, way: FloatArray, radius: FloatArray, facets: Facets
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return two angles at which a surface passes the ring about each segment, and whether there are two.

    Angles are in radians about ``way``; the second is the one that differs most from the first.
    """
    seg, tri = facets.near(middles, float(radius.max(initial=0.0)) / 2)
    across = np.cross(facets.normals[tri], way[seg])
    seg, arm = np.concatenate([seg, seg]), np.concatenate([across, -across])
    far = np.zeros(len(seg))
    for _ in range(_ROUNDS):
        # the point of the ring in that direction, and from there to the surface: soon they are one
        size = np.linalg.norm(arm, axis=1)
        good = size > 0
        seg, arm = seg[good], arm[good] / size[good, None]
        sought = middles[seg] + radius[seg, None] * arm
        place = _nearest(sought, facets)[0]
        far = np.linalg.norm(place - sought, axis=1) / radius[seg]
        arm = place - middles[seg]
        arm -= np.einsum("ij,ij->i", arm, way[seg])[:, None] * way[seg]
    seg, arm = seg[far <= _ON_RING], arm[far <= _ON_RING]
    # any two axes across the way: one far from parallel to it is turned into its plane
    u = np.cross(way, np.eye(3)[np.argmin(np.abs(way), axis=1)])
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(way, u)
    angle = np.arctan2(np.einsum("ij,ij->i", arm, v[seg]), np.einsum("ij,ij->i", arm, u[seg]))
    first = np.zeros(len(middles))
    first[seg[::-1]] = angle[::-1]
    turn = np.abs((angle - first[seg] + np.pi) % (2 * np.pi) - np.pi)
    second, widest = first.copy(), np.zeros(len(middles))
    order = np.argsort(turn, kind="stable")
    second[seg[order]], widest[seg[order]] = angle[order], turn[order]
    return first, second, widest > _ONE_WAY
