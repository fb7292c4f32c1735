"""Whether the plan projection of a triangulated surface is injective, and where not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.surface import Surface, edge_sharing, edge_table, triangle_dips, triangle_normals
from graben.validators.measures import components, smallest_angles, with_three_corners

#: Dip above which a triangle is vertical, degrees.
VERTICAL = 89.9
#: Width over the mean edge in plan below which an overlap is a matter of rounding, as along a crack whose
#: two lips were written with few decimals.
OVERLAP_WIDTH = 1e-3


@dataclass(frozen=True, eq=False)
class Projection:
    """How the triangles of a surface lie in plan.

    Parameters
    ----------
    dips : (m,) array
        Degrees: above 90 where a triangle is overturned, seen from most of its component; 0 without area.
    vertical, overturned : (k,) arrays
        Indices of those triangles; a vertical one is not overturned as well.
    """

    dips: FloatArray
    vertical: IntArray
    overturned: IntArray


def projected(surface: Surface) -> Projection:
    """Return how the triangles of a surface lie in plan; those without area lie nowhere."""
    dips = np.zeros(len(surface.triangles))
    kept = with_three_corners(surface)
    kept = kept[smallest_angles(surface.vertices, surface.triangles[kept]) > 0]
    if not len(kept):
        return Projection(floats(dips), ints([]), ints([]))
    triangles = ints(surface.triangles[kept])
    steep = triangle_dips(surface.vertices, triangles)
    signs, part = orientation(triangles)
    up = signs * triangle_normals(surface.vertices, triangles)[:, 2]
    turned = up * np.where(np.bincount(part, up) < 0, -1.0, 1.0)[part] < 0
    vertical = steep > VERTICAL
    dips[kept] = np.where(turned, 180.0 - steep, steep)
    return Projection(floats(dips), ints(kept[vertical]), ints(kept[turned & ~vertical]))


def orientation(triangles: IntArray) -> tuple[FloatArray, IntArray]:
    """Return the sign that orients each triangle with its neighbours, and its component, shapes (m,).

    Each triangle stands twice in a graph, once each way up; neighbours are joined the way they fit. A
    component that can be oriented falls into two halves, of which the one with the first triangle as it
    is gives the signs; one that cannot keeps signs of 1.
    """
    m = len(triangles)
    edges, sides = edge_table(triangles)
    upward = triangles[:, [1, 2, 0]] < triangles[:, [2, 0, 1]]
    inner = np.isin(sides, np.flatnonzero(edge_sharing(sides, len(edges)) == 2))
    order = np.argsort(sides[inner], kind="stable")
    pair = np.repeat(np.arange(m), 3).reshape(m, 3)[inner][order].reshape(-1, 2)
    fits = np.diff(upward[inner][order].reshape(-1, 2).astype(int), axis=1)[:, 0] != 0
    other = pair[:, 1] + np.where(fits, 0, m)
    both = components(
        2 * m, np.concatenate([np.c_[pair[:, 0], other], np.c_[pair[:, 0] + m, (other + m) % (2 * m)]])
    )
    _, first, part = np.unique(components(m, pair), return_index=True, return_inverse=True)
    part = part.reshape(-1)
    agrees = both[:m] == both[first][part]
    return floats(np.where(agrees, 1.0, -1.0)), ints(part)


def overlaps(surface: Surface) -> tuple[FloatArray, FloatArray]:
    """Return where a surface covers a place of the plan more than once.

    With every triangle turned counter-clockwise in plan, the winding number of the boundary of their sum
    about a place is the number of triangles over it. So only the faces between the boundary lines are
    looked at, one point each.

    Returns
    -------
    areas : (k,) array
        Plan area of each face covered more than once, square model units.
    points : (k, 2) array
        A point inside each.
    """
    kept = with_three_corners(surface)
    ends = _outline(surface.vertices, surface.triangles[kept])
    nothing = floats(np.zeros(0)), floats(np.zeros((0, 2)))
    if not len(ends):
        return nothing
    lines = shapely.union_all(shapely.linestrings(ends))
    faces = shapely.get_parts(shapely.polygonize([lines]))
    edges = (
        surface.vertices[surface.triangles[kept]][:, [1, 2, 0], :2]
        - surface.vertices[surface.triangles[kept]][:, :, :2]
    )
    step = float(np.linalg.norm(edges, axis=2).mean())
    areas = shapely.area(faces)
    wide = 2.0 * areas > OVERLAP_WIDTH * step * shapely.length(faces)
    faces, areas = faces[wide], areas[wide]
    if not len(faces):
        return nothing
    points = shapely.get_coordinates(shapely.point_on_surface(faces))
    double = winding_numbers(points, ends) > 1
    return floats(areas[double]), floats(points[double], -1, 2)


def _outline(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Return the directed edges that bound the sum of the triangles in plan, each as often as it counts.

    Every triangle counts counter-clockwise; shape (b, 2, 2).
    """
    plan = vertices[:, :2]
    turn = triangle_normals(vertices, triangles)[:, 2]
    ccw = np.where(turn[:, None] < 0, triangles[:, ::-1], triangles)[turn != 0]
    edges, sides = edge_table(ints(ccw, -1, 3))
    upward = ccw[:, [1, 2, 0]] < ccw[:, [2, 0, 1]]
    net = np.bincount(sides.ravel(), np.where(upward, 1.0, -1.0).ravel(), minlength=len(edges)).astype(int)
    directed = np.where((net < 0)[:, None], edges[:, ::-1], edges)
    return np.asarray(plan[np.repeat(directed, np.abs(net), axis=0)], dtype=np.float64).reshape(-1, 2, 2)


def winding_numbers(points: FloatArray, ends: FloatArray) -> IntArray:
    """Return how often closed lines, given by directed segments (b, 2, 2), go round points (p, 2).

    >>> corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    >>> square = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    >>> winding_numbers(floats([[0.5, 0.5], [2, 0]]), square).tolist()
    [1, 0]
    """
    a, b = ends[:, 0], ends[:, 1]

    def count(point: FloatArray) -> int:
        left = (b[:, 0] - a[:, 0]) * (point[1] - a[:, 1]) - (point[0] - a[:, 0]) * (b[:, 1] - a[:, 1])
        rising: BoolArray = (a[:, 1] <= point[1]) & (b[:, 1] > point[1]) & (left > 0)
        falling: BoolArray = (a[:, 1] > point[1]) & (b[:, 1] <= point[1]) & (left < 0)
        return int(rising.sum()) - int(falling.sum())

    return ints([count(p) for p in points])
