"""What is derived from a rebuilt horizon: its regular grid and the fault polygons in plan."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from graben.arrays import FloatArray, IntArray, floats
from graben.errors import ModelingError
from graben.model import GridGeometry
from graben.modeling.results import Cutoff, HorizonResult

if TYPE_CHECKING:
    from shapely import Polygon

#: Barycentric coordinates down to minus this count as inside: nodes on an edge belong to its triangles.
_ON_EDGE = 1e-7
#: Rings whose area is below this share of the square of their length are closed cutoffs, not polygons.
_FLAT = 1e-10


def regular_grid(result: HorizonResult) -> FloatArray:
    """Return the rebuilt horizon on the nodes of its regular grid.

    A node in a fault gap or outside the horizon is undefined. In a reverse overlap a vertical line meets
    the horizon on both sides of the fault; the hanging wall is, by its definition, the upper of the two.

    Parameters
    ----------
    result : HorizonResult
        A rebuilt horizon whose ``horizon.grid`` says where the nodes are.

    Returns
    -------
    (columns, rows) array
        Elevation, model units; NaN where undefined.

    Raises
    ------
    ModelingError
        When the horizon has no grid.
    """
    grid = result.horizon.grid
    if grid is None:
        raise ModelingError(f"Horizon {result.name!r} has no regular grid to write its result on.")
    places = _grid_coordinates(grid, result.surface.vertices)
    return floats(
        _sampled(places, result.surface.vertices[:, 2], result.surface.triangles, grid.columns, grid.rows)
    )


def _grid_coordinates(grid: GridGeometry, points: FloatArray) -> FloatArray:
    """Return plan positions in columns and rows of the grid, shape (n, 2): node (i, j) is (i, j)."""
    x, y = points[:, 0] - grid.origin[0], points[:, 1] - grid.origin[1]
    a = np.radians(grid.rotation)
    along, across = x * np.cos(a) + y * np.sin(a), y * np.cos(a) - x * np.sin(a)
    return floats(np.stack([along / grid.dx, across / grid.dy], axis=1))


def _sampled(
    places: FloatArray, values: FloatArray, triangles: IntArray, columns: int, rows: int
) -> FloatArray:
    """Return the greatest value of the triangles over each node of the integer lattice, NaN for none.

    All (triangle, node in its bounding box) pairs are made at once; where triangles and grid cells are of
    like size these are a few for each triangle.
    """
    corners = places[triangles]
    low = np.maximum(np.ceil(corners.min(axis=1) - _ON_EDGE), 0).astype(np.int64)
    high = np.minimum(np.floor(corners.max(axis=1) + _ON_EDGE), [columns - 1, rows - 1]).astype(np.int64)
    width, height = np.maximum(high - low + 1, 0).T
    count = width * height
    t = np.repeat(np.arange(len(triangles)), count)
    rank = np.arange(len(t)) - np.repeat(np.cumsum(count) - count, count)
    i = low[t, 0] + rank // height[t]
    j = low[t, 1] + rank % height[t]

    a, b, c = (corners[t, k] for k in range(3))
    p = np.stack([i, j], axis=1)
    area = _cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):  # a triangle without area is met by none
        weights = (
            np.stack([_cross(b - p, c - p), _cross(c - p, a - p), _cross(a - p, b - p)], axis=1)
            / area[:, None]
        )
    inside = (weights >= -_ON_EDGE).all(axis=1)
    found = (weights[inside] * values[triangles[t[inside]]]).sum(axis=1)

    lattice = np.full((columns, rows), -np.inf)
    np.maximum.at(lattice, (i[inside], j[inside]), found)
    return floats(np.where(np.isinf(lattice), np.nan, lattice))


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], dtype=np.float64)


def fault_polygons(result: HorizonResult) -> list[tuple[str, Polygon]]:
    """Return the fault polygons of a rebuilt horizon in plan.

    A polygon runs along the hanging cutoff and back along that of the foot. Where the lips cross (a fault
    that is normal at one end and reverse at the other) it becomes several; cutoffs that lie on each other
    in plan (a vertical fault) give none.

    Returns
    -------
    list of (str, shapely.Polygon)
        Name of the fault and a valid polygon, in the order of ``result.cutoffs``.
    """
    return [(cutoff.fault, polygon) for cutoff in result.cutoffs for polygon in cutoff_polygons(cutoff)]


def cutoff_polygons(cutoff: Cutoff) -> list[Polygon]:
    """Return the valid polygons between the two lips of one cutoff, none where they enclose no area."""
    import shapely

    ring = np.concatenate([cutoff.hanging[:, :2], cutoff.foot[::-1, :2]])
    # A tip is a pair of equal points; a ring needs each once.
    ring = ring[np.append(True, (ring[1:] != ring[:-1]).any(axis=1))]
    if len(ring) < 3:
        return []
    flat = _FLAT * float(np.hypot(*np.diff(ring, axis=0).T).sum()) ** 2
    parts = shapely.get_parts(shapely.make_valid(shapely.Polygon(ring)))
    parts = shapely.get_parts(parts)  # a collection may hold a multipolygon
    return [part for part in parts if part.geom_type == "Polygon" and part.area > flat]
