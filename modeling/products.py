"""What is derived from a rebuilt horizon: its regular grid, its parts, and the fault polygons in plan."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np

from graben.arrays import FloatArray, IntArray, bools, floats, ints
from graben.errors import ModelingError
from graben.model import GridGeometry
from graben.modeling.results import Cutoff, HorizonResult
from graben.proximity import nearest
from graben.surface import Surface

if TYPE_CHECKING:
    from shapely import Polygon

#: Barycentric coordinates down to minus this count as inside: nodes on an edge belong to its triangles.
_ON_EDGE = 1e-7
#: A vertex nearer to a node of the grid than this, in cells, stands on it: above the rounding of coordinates
#: of hundreds of kilometres, and the slope over so short a way is nothing.
_ON_NODE = 1e-9
#: Triangles that are looked at together, so that their pairs fit into memory.
_AT_ONCE = 200_000
#: Rounding of a place, as a share of the largest coordinate.
_ROUNDING = 1e-12
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
    """Return the greatest value of the triangles over each node of the integer lattice, NaN for none."""
    lattice = np.full((columns, rows), -np.inf)
    node = ints(np.round(places))
    on = bools((np.abs(places - node) <= _ON_NODE).all(axis=1) & (node >= 0).all(axis=1))
    on = bools(on & (node < [columns, rows]).all(axis=1))
    # Away from the faults triangles are half cells of the grid: over no node but their corners.
    a, b, c = (node[triangles[:, k]] for k in range(3))
    extent = np.maximum(np.maximum(a, b), c) - np.minimum(np.minimum(a, b), c)
    half = on[triangles].all(axis=1) & (extent <= 1).all(axis=1)
    corner = np.zeros(len(places), dtype=bool)
    corner[triangles[half]] = True
    np.maximum.at(lattice, tuple(node[corner].T), values[corner])
    rest = np.flatnonzero(~half)
    for start in range(0, len(rest), _AT_ONCE):
        i, j, found = _met(places, values, triangles[rest[start : start + _AT_ONCE]], columns, rows)
        np.maximum.at(lattice, (i, j), found)
    return floats(np.where(np.isinf(lattice), np.nan, lattice))


def _met(
    places: FloatArray, values: FloatArray, triangles: IntArray, columns: int, rows: int
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return column and row of each node that a triangle lies over, and the triangle's value there.

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
    return i[inside], j[inside], floats((weights[inside] * values[triangles[t[inside]]]).sum(axis=1))


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], dtype=np.float64)


def parts(result: HorizonResult) -> tuple[tuple[int, Surface], ...]:
    """Return the cut horizon as one surface for each subdomain, with its id.

    Triangles and nodes keep their order. A horizon that no fault divides is one part.
    """
    surface = result.surface
    owner = result.subdomain[surface.triangles[:, 0]]
    found = []
    for label in np.unique(owner).tolist():
        triangles = surface.triangles[owner == label]
        used = np.zeros(len(surface.vertices), dtype=bool)
        used[triangles] = True
        name = f"{surface.name} part {label}"
        found.append((label, Surface(name, surface.vertices[used], (np.cumsum(used) - 1)[triangles])))
    return tuple(found)


class Opening(StrEnum):
    """What lies between the two lips of a fault in plan."""

    GAP = "gap"  #: no horizon: a normal fault
    OVERLAP = "overlap"  #: the horizon twice: a reverse fault


@dataclass(frozen=True, eq=False)
class FaultPolygon:
    """The part of the plan between the lips of a piece of a fault on a horizon.

    ``piece`` numbers the pieces of the fault on the horizon from 1; the exterior of ``shape``, valid in plan
    and with the elevations of the lips, runs counter-clockwise.
    """

    fault: str
    piece: int
    kind: Opening
    shape: Polygon


def fault_polygons(result: HorizonResult) -> list[tuple[str, Polygon]]:
    """Return the fault polygons of a rebuilt horizon: names of faults and shapes of :func:`polygons_of`."""
    return [(polygon.fault, polygon.shape) for polygon in polygons_of(result)]


def polygons_of(result: HorizonResult) -> tuple[FaultPolygon, ...]:
    """Return the fault polygons of a rebuilt horizon, in the order of ``result.cutoffs``.

    A polygon runs along the hanging cutoff and back along that of the foot. Where the lips cross (a fault
    that is normal at one end and reverse at the other) it becomes several; cutoffs that lie on each other
    in plan (a vertical fault) give none. Where faults cross, both have the part of the plan between the four
    corners. All gaps together are what the horizon does not cover, all overlaps what it covers twice.
    """
    count: dict[str, int] = {}
    found: list[FaultPolygon] = []
    for cutoff in result.cutoffs:
        piece = count[cutoff.fault] = count.get(cutoff.fault, 0) + 1
        found += [FaultPolygon(cutoff.fault, piece, kind, shape) for kind, shape in _parts(cutoff)]
    return tuple(found)


def cutoff_polygons(cutoff: Cutoff) -> list[Polygon]:
    """Return the valid polygons in plan between the lips of one cutoff, none where they enclose no area."""
    import shapely

    return [shapely.force_2d(shape) for _, shape in _parts(cutoff)]


def _parts(cutoff: Cutoff) -> list[tuple[Opening, Polygon]]:
    """Return gaps and overlaps of one cutoff.

    The ring of both lips winds once about a gap in the positive sense, since the fault dips to the right of
    the way, and about an overlap in the negative.
    """
    import shapely
    from shapely.geometry.polygon import orient

    ring = np.concatenate([cutoff.hanging[:, :2], cutoff.foot[::-1, :2]])
    # A tip is a pair of equal points; a ring needs each once.
    ring = ring[np.append(True, (ring[1:] != ring[:-1]).any(axis=1))]
    if len(ring) < 3:
        return []
    closed = np.concatenate([ring, ring[:1]])
    flat = _FLAT * float(np.hypot(*np.diff(closed, axis=0).T).sum()) ** 2
    faces = shapely.get_parts(shapely.polygonize([shapely.union_all(shapely.linestrings(closed))]))
    inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    winding = _winding(closed, inside)
    found = []
    for kind, mine in ((Opening.GAP, winding > 0), (Opening.OVERLAP, winding < 0)):
        for part in shapely.get_parts(shapely.union_all(faces[mine])):
            if part.area > flat:
                found.append((kind, _with_heights(cutoff, orient(part))))
    return found


def _winding(ring: FloatArray, points: FloatArray) -> IntArray:
    """Return how often a closed ring (n, 2) winds about each point (k, 2), none of them on it, (k,)."""
    a, b = ring[:-1, None], ring[1:, None]
    up = (a[..., 1] <= points[:, 1]) & (b[..., 1] > points[:, 1])
    down = (a[..., 1] > points[:, 1]) & (b[..., 1] <= points[:, 1])
    way, to = b - a, points - a
    left = way[..., 0] * to[..., 1] - way[..., 1] * to[..., 0]
    return ints((up & (left > 0)).sum(axis=0) - (down & (left < 0)).sum(axis=0))


def _with_heights(cutoff: Cutoff, polygon: Polygon) -> Polygon:
    """Return a polygon in plan with the elevations of the lips that its corners lie on."""
    import shapely

    at = shapely.get_coordinates(polygon)
    lips = [_height(line, at) for line in (cutoff.hanging, cutoff.foot)]
    # A corner where the lips cross lies on both; one between the corners of a junction on neither.
    nearer = np.min([away for away, _ in lips], axis=0)
    on = np.stack([away <= nearer + _ROUNDING * np.abs(at).max() for away, _ in lips])
    z = (on * np.stack([z for _, z in lips])).sum(axis=0) / on.sum(axis=0)
    lifted = shapely.force_3d(polygon)
    return shapely.set_coordinates(lifted, np.column_stack([at, z]))


def _height(line: FloatArray, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the plan distance of points (k, 2) to a line (n, 3), and its elevation next to them, (k,)."""
    edges = np.stack([np.arange(len(line) - 1), np.arange(1, len(line))], axis=1)
    near = nearest(at, line, edges)
    a, b = line[near.simplex], line[near.simplex + 1]
    way = (b - a)[:, :2]
    size = np.maximum((way**2).sum(axis=1), np.finfo(np.float64).tiny)
    share = np.clip(((near.place - a[:, :2]) * way).sum(axis=1) / size, 0.0, 1.0)
    return near.distance, floats(a[:, 2] + share * (b - a)[:, 2])
