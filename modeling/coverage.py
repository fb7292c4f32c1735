"""The area that scattered points cover, and a triangulation of it with good triangles.

All lengths here are in steps: one node on each unit square. The rule of the area:

1. A triangle of the Delaunay triangulation of the points belongs to it when its circumcircle is small: of a
   radius up to :data:`REACH` steps, or :data:`REACH_OF_SPACING` times the spacing of the points where these
   lie further apart than the step. (Where no such triangle is, a point has no neighbours around it.)
2. Its outline is moved out by :data:`MARGIN` steps; bays narrower than twice :data:`SMOOTHING` are filled
   and necks narrower than twice :data:`NECK` cut, so that the outline has no teeth.
3. Inner holes narrower than :data:`HOLE` steps are filled.
4. Parts of less than :data:`LEAST_PART` square steps are left out, and so are those whose points lie within
   :data:`LEAST_WIDTH` steps of one line; the largest of the others always stays.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
import triangle
from scipy.spatial import Delaunay, cKDTree

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.errors import ModelingError
from graben.modeling.lattice import EDGE_OF_UNIT_STEP, hexagonal

REACH = 3.0
REACH_OF_SPACING = 1.5
MARGIN = 1.0
SMOOTHING = 4.0
NECK = 0.75
HOLE = 10.0
LEAST_PART = 25.0
LEAST_WIDTH = 0.25

#: Share of the points whose distance to their nearest neighbour is at most their spacing.
_SPACING_SHARE = 0.95
#: Distance of the first lattice nodes from the outline, in lattice edges.
_CLEARANCE = 0.6
#: Direction of the first node of an outline: oblique to the sides of a rectangle, so that one corner has it.
_START = np.array([1.0, 0.3])
#: Straight pieces of a quarter of a circle in rounded outlines.
_ROUNDNESS = 16


@dataclass(frozen=True, eq=False)
class Coverage:
    """The area that points cover.

    Parameters
    ----------
    parts : tuple of shapely.Polygon
        Disjoint, the largest first; in steps.
    shares : (p,) array
        Area of the covered plane nearer to each point than to the others, square steps; zero for points
        that stand alone.
    left_out : int
        Number of parts that rule 4 left out.
    """

    parts: tuple[Any, ...]
    shares: FloatArray
    left_out: int


def covered(points: FloatArray) -> Coverage:
    """Return the area that different points, shape (p, 2), in steps, cover.

    Raises
    ------
    ModelingError
        When there are fewer than three points or they lie in one line.
    """
    if len(points) < 3 or _width(points) < LEAST_WIDTH:
        raise ModelingError(f"they lie within {LEAST_WIDTH:g} steps of one line in plan")
    triangles = Delaunay(points).simplices
    spacing = np.quantile(cKDTree(points).query(points, k=2)[0][:, 1], _SPACING_SHARE)
    reach = max(REACH, REACH_OF_SPACING * float(spacing))
    kept = triangles[_circumradii(points, triangles) <= reach]
    if len(kept) == 0:
        raise ModelingError(f"no three of them lie within {2 * reach:.3g} steps of each other")
    area = shapely.coverage_union_all(shapely.polygons(points[kept]))
    for distance in (MARGIN + SMOOTHING, -SMOOTHING - NECK, NECK):
        area = area.buffer(distance, quad_segs=_ROUNDNESS)
    parts = [_without_small_holes(part) for part in shapely.get_parts(area)]
    parts.sort(key=lambda part: -part.area)
    sound = [part for part in parts if _supported(part, points)]
    if not sound:
        raise ModelingError(f"they lie within {LEAST_WIDTH:g} steps of one line in plan")
    large = [part for part in sound if part.area >= LEAST_PART] or sound[:1]
    shares = np.zeros(len(points))
    np.add.at(shares, kept.ravel(), _nearest_areas(points, kept).ravel())
    return Coverage(tuple(large), floats(shares), len(parts) - len(large))


def meshed(part: Any) -> tuple[FloatArray, IntArray]:
    """Return a triangulation of one part: a hexagonal lattice inside, nodes evenly spaced on the outline.

    Parameters
    ----------
    part : shapely.Polygon
        In steps.

    Returns
    -------
    points : (n, 2) array
        In steps.
    triangles : (m, 3) array
        Counter-clockwise.
    """
    rings = [_resampled(shapely.get_coordinates(ring)) for ring in (part.exterior, *part.interiors)]
    outline = shapely.Polygon(rings[0], rings[1:])
    low, high = floats(outline.bounds[:2]), floats(outline.bounds[2:])
    nodes = hexagonal(low, high, EDGE_OF_UNIT_STEP, origin=floats([0.0, 0.0]))
    core = outline.buffer(-_CLEARANCE * EDGE_OF_UNIT_STEP)
    shapely.prepare(core)
    nodes = nodes[shapely.contains_xy(core, nodes[:, 0], nodes[:, 1])]
    starts = np.cumsum([0] + [len(ring) for ring in rings])
    along = np.arange(starts[-1])
    segments = np.stack(
        [along, np.concatenate([np.roll(along[a:b], -1) for a, b in pairwise(starts)])], axis=1
    )
    vertices = np.concatenate([*rings, nodes])
    made = triangle.triangulate({"vertices": vertices, "segments": segments}, "p")
    points, triangles = made["vertices"], made["triangles"].astype(np.int64)
    shapely.prepare(outline)
    inside = shapely.contains_xy(outline, points[triangles].mean(axis=1))
    return floats(points), ints(triangles[inside])


def _width(points: FloatArray) -> float:
    """Return the standard deviation of points across the line that fits them best."""
    centred = points - points.mean(axis=0)
    return float(np.sqrt(max(np.linalg.eigvalsh(centred.T @ centred / len(points))[0], 0.0)))


def _circumradii(points: FloatArray, triangles: IntArray) -> FloatArray:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    double_area = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    sides = [np.linalg.norm(d, axis=1) for d in (u, v, c - b)]
    with np.errstate(divide="ignore"):
        return np.asarray(sides[0] * sides[1] * sides[2] / (2.0 * double_area), dtype=np.float64)


def _nearest_areas(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Return the area of each triangle nearest to each of its corners, (m, 3).

    In an obtuse triangle the obtuse corner has half, the others a quarter each: so no share is negative and
    the shares add up (the mixed area of Meyer, Desbrun, Schroeder and Barr 2003).
    """
    corner = points[triangles]
    after, before = np.roll(corner, -1, axis=1) - corner, np.roll(corner, 1, axis=1) - corner
    dots = (after * before).sum(axis=2)
    area = 0.5 * np.abs(after[:, 0, 0] * before[:, 0, 1] - after[:, 0, 1] * before[:, 0, 0])[:, None]
    cotangents = dots / (2.0 * area)
    squares = (after * after).sum(axis=2)
    # Edge "after" of corner k is opposite to corner k + 2, edge "before" to corner k + 1.
    own = np.roll(cotangents, -2, axis=1) * squares
    shares = (own + np.roll(cotangents, -1, axis=1) * np.roll(squares, 1, axis=1)) / 8.0
    obtuse = dots < 0
    halves = area * np.where(obtuse, 0.5, 0.25)
    return np.where(obtuse.any(axis=1)[:, None], halves, shares)


def _without_small_holes(part: Any) -> Any:
    holes = [hole for hole in part.interiors if not shapely.Polygon(hole).buffer(-HOLE / 2.0).is_empty]
    return shapely.Polygon(part.exterior, holes)


def _supported(part: Any, points: FloatArray) -> bool:
    shapely.prepare(part)
    return _width(points[shapely.contains_xy(part, points[:, 0], points[:, 1])]) >= LEAST_WIDTH


def _resampled(ring: FloatArray) -> FloatArray:
    """Return nodes evenly spaced along a closed ring, about a lattice edge apart, without a repeated end.

    They start where the ring reaches furthest in a direction of the frame, so that they turn with it.
    """
    start = int(np.argmax(ring[:-1] @ _START))
    ring = np.concatenate([ring[start:-1], ring[: start + 1]])
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
    count = max(6, round(arc[-1] / EDGE_OF_UNIT_STEP))
    at = np.linspace(0.0, arc[-1], count, endpoint=False)
    return np.stack([np.interp(at, arc, ring[:, k]) for k in range(2)], axis=1)
