"""How two triangles lie to each other in space, over arrays of pairs."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray

#: Corner k + 1 of a triangle, for side k from corner k to it.
NEXT = np.array([1, 2, 0])
#: The six side functions of two triangles, two by two.
_TWO = np.array(list(combinations(range(6), 2)))


@dataclass(frozen=True, eq=False)
class Lines:
    """The lines that pairs of triangles have in common, and how deep inside both they come.

    Parameters
    ----------
    pair : (q,) array
        Which of the pairs; the others have none longer than the distance of a touch.
    ends : (q, 2, 3) array
        Their ends.
    depth : (q,) array
        Greatest distance of a point of the line from the sides of both triangles, but those along which
        it runs.
    along : (q, 2) array
        The side of either triangle along which it runs, -1 where it runs inside.
    """

    pair: IntArray
    ends: FloatArray
    depth: FloatArray
    along: IntArray


def heights_over(corners: FloatArray, normals: FloatArray, points: FloatArray, touch: float) -> FloatArray:
    """Return the signed distances of points from planes, 0 within the distance of a touch.

    Parameters
    ----------
    corners, normals : (p, 3, 3) and (p, 3) arrays
        Triangles and their unit normals.
    points : (p, k, 3) array
        Points asked for each.
    touch : float
        Distance taken as none.
    """
    distance = np.einsum("pkd,pd->pk", points - corners[:, :1], normals)
    return np.where(np.abs(distance) <= touch, 0.0, distance)


def common_lines(
    corners: tuple[FloatArray, FloatArray], normals: tuple[FloatArray, FloatArray], touch: float
) -> Lines:
    """Return the lines that pairs of triangles in different planes have in common.

    Parameters
    ----------
    corners : two (p, 3, 3) arrays
        The triangles, model units.
    normals : two (p, 3) arrays
        Their unit normals.
    touch : float
        A corner this near to the other plane lies in it; a line this near to a side runs along it.
    """
    heights = [heights_over(corners[k], normals[k], corners[1 - k], touch) for k in (1, 0)]
    pair = np.flatnonzero(_met(heights[0]) & _met(heights[1]))
    corners = (corners[0][pair], corners[1][pair])
    normals = (normals[0][pair], normals[1][pair])
    way = np.cross(normals[0], normals[1])
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    cuts = [_cut(corners[k], heights[k][pair], way) for k in (0, 1)]
    spans = [np.einsum("pkd,pd->pk", cut, way) for cut in cuts]
    low, high = (
        np.maximum(spans[0][:, 0], spans[1][:, 0]),
        np.minimum(spans[0][:, 1], spans[1][:, 1]),
    )
    long = np.flatnonzero(high - low > touch)
    places = np.stack([low, high], axis=1)[long]
    points = [_at(cuts[k][long], spans[k][long], places) for k in (0, 1)]
    inside = np.concatenate([_inside(corners[k][long], normals[k][long], points[k]) for k in (0, 1)], axis=1)
    beside = (np.abs(inside) <= touch).all(axis=2)
    along = np.stack(
        [np.where(b.any(axis=1), np.argmax(b, axis=1), -1) for b in (beside[:, :3], beside[:, 3:])], axis=1
    )
    depth = _deepest(np.where(beside[:, :, None], np.inf, inside))
    # a line along two sides of one triangle lies in its corner
    depth[(beside[:, :3].sum(axis=1) > 1) | (beside[:, 3:].sum(axis=1) > 1)] = 0.0
    return Lines(pair[long], (points[0] + points[1]) / 2.0, depth, along)


def unit_normals(normals: FloatArray) -> FloatArray:
    """Return vectors (m, 3) divided by their lengths; 0 where that is 0."""
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(normals / np.where(size > 0, size, 1.0))


def leeway(corners: tuple[FloatArray, FloatArray], normals: FloatArray) -> FloatArray:
    """Return by how much pairs of triangles in one plane must be moved in it to come apart, shape (p,).

    The least over the directions across the six sides; negative where they lie apart. ``normals`` (p, 3)
    are those of the plane.
    """
    least = np.full(len(corners[0]), np.inf)
    for k in (0, 1):
        for side in range(3):
            edge = corners[k][:, NEXT[side]] - corners[k][:, side]
            across = unit_normals(np.cross(normals, edge))
            first, second = (np.einsum("pkd,pd->pk", c, across) for c in corners)
            out = np.minimum(first.max(axis=1) - second.min(axis=1), second.max(axis=1) - first.min(axis=1))
            least = np.minimum(least, out)
    return least


def _met(heights: FloatArray) -> BoolArray:
    """Return which triangles have more than a point in the other's plane, but are not in it themselves."""
    above, below = (heights > 0).any(axis=1), (heights < 0).any(axis=1)
    return np.asarray((above & below) | ((heights == 0).sum(axis=1) == 2))


def _cut(corners: FloatArray, heights: FloatArray, way: FloatArray) -> FloatArray:
    """Return the ends of the line in which triangles meet a plane, in the order of ``way``, (q, 2, 3)."""
    ahead = heights[:, NEXT]
    through = heights * ahead < 0
    share = np.divide(heights, heights - ahead, out=np.zeros_like(heights), where=through)
    crossed = corners + share[:, :, None] * (corners[:, NEXT] - corners)
    points = np.concatenate([corners, crossed], axis=1)
    known = np.concatenate([heights == 0, through], axis=1)
    two = np.argsort(~known, axis=1, kind="stable")[:, :2]
    ends = np.take_along_axis(points, two[:, :, None], axis=1)
    order = np.argsort(np.einsum("pkd,pd->pk", ends, way), axis=1)
    return np.asarray(np.take_along_axis(ends, order[:, :, None], axis=1))


def _at(ends: FloatArray, span: FloatArray, places: FloatArray) -> FloatArray:
    """Return the points of lines at given places along their way, shape (q, 2, 3)."""
    length = (span[:, 1] - span[:, 0])[:, None]
    share = np.divide(places - span[:, :1], length, out=np.zeros_like(places), where=length > 0)
    return np.asarray(ends[:, :1] + share[:, :, None] * (ends[:, 1:] - ends[:, :1]))


def _inside(corners: FloatArray, normals: FloatArray, points: FloatArray) -> FloatArray:
    """Return how far points (q, 2, 3) lie inside each side of their triangle, shape (q, 3, 2)."""
    edges = corners[:, NEXT] - corners
    inward = np.cross(normals[:, None, :], edges)
    inward /= np.linalg.norm(inward, axis=2, keepdims=True)
    return np.asarray(np.einsum("pskd,psd->psk", points[:, None] - corners[:, :, None], inward))


def _deepest(inside: FloatArray) -> FloatArray:
    """Return the greatest, along lines, of the least of six functions given at both ends (q, 6, 2).

    Functions that are infinite at both ends take no part.
    """
    start, slope = inside[:, :, 0], np.zeros(inside.shape[:2])
    np.subtract(inside[:, :, 1], start, out=slope, where=np.isfinite(start))
    first, second = _TWO.T
    finite = np.where(np.isfinite(start), start, 0.0)
    difference = slope[:, second] - slope[:, first]
    # where two functions are equal the least of all may have its top
    share = np.zeros((len(start), len(_TWO) + 2))
    np.divide(finite[:, first] - finite[:, second], difference, out=share[:, 2:], where=difference != 0)
    share[:, 1] = 1.0
    values = start[:, None, :] + np.clip(share, 0.0, 1.0)[:, :, None] * slope[:, None, :]
    return np.asarray(values.min(axis=2).max(axis=1))
