"""Whether the plan projection of a triangulated surface is injective, and where not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from graben.arrays import BoolArray, FloatArray, IntArray, floats, ints
from graben.surface import Surface
from graben.validators.measuring.measures import (
    ANGLE_ROUNDING,
    Mesh,
    angles_of,
    components,
    mesh_of,
    meshed,
    normals_of,
    remembered,
    welded_mesh_of,
)

#: Dip above which a triangle is vertical, degrees.
VERTICAL = 89.9
#: Share of the area in plan by which more of a surface must face one way than the other to tell its top.
EVEN = 1e-6
#: Boxes of boundary lines may meet this often for each line, and besides in all, before a view is tangled.
MEETINGS_EACH = 8
MEETINGS_FREE = 5_000
#: Lines whose neighbours are asked for at once.
LINES_AT_ONCE = 1000
#: Grid over the extent to which crossings of boundary lines are rounded, so that lines upon lines are one.
GRID = 1e-10
#: Share of the covered area that may be missing from the faces found.
CLOSED = 1e-6
#: Points times lines that are worked on at once.
PRODUCTS_AT_ONCE = 1_000_000
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


@remembered
def projected(surface: Surface) -> Projection:
    """Return how the triangles of a surface lie in plan; those without area lie nowhere."""
    dips = np.zeros(len(surface.triangles))
    solid = angles_of(surface) > 0
    mesh = mesh_of(surface)
    if not solid[mesh.kept].all():
        mesh = meshed(surface.triangles, np.flatnonzero(solid))
    if not len(mesh.kept):
        return Projection(floats(dips), ints([]), ints([]))
    kept = mesh.kept
    normals = normals_of(surface)[kept]
    steep = np.degrees(np.arctan2(np.hypot(normals[:, 0], normals[:, 1]), np.abs(normals[:, 2])))
    signs, part = orientation(mesh)
    up = signs * normals[:, 2]
    upright = _upright(surface.vertices[mesh.triangles, 2].mean(axis=1), up, part)[part]
    turned = np.where(upright == 0, np.abs(up) > 0, up * upright < 0)
    vertical = steep > VERTICAL - ANGLE_ROUNDING
    dips[kept] = np.where(turned, 180.0 - steep, steep)
    return Projection(floats(dips), ints(kept[vertical]), ints(kept[turned & ~vertical]))


def _upright(heights: FloatArray, up: FloatArray, part: IntArray) -> FloatArray:
    """Return the sign with which most of each part faces upwards, by its area in plan ``up``.

    Where neither way has more, its upper triangles face upwards; 0 where they lie no higher either.
    """
    balance, total = np.bincount(part, up), np.bincount(part, np.abs(up))
    middle = np.bincount(part, np.abs(up) * heights) / np.where(total > 0, total, 1.0)
    above = heights - middle[part]
    lean, spread = np.bincount(part, up * above), np.bincount(part, np.abs(up * above))
    side = np.where(np.abs(lean) <= EVEN * spread, 0.0, np.sign(lean))
    return floats(np.where(np.abs(balance) <= EVEN * total, side, np.sign(balance)))


def orientation(mesh: Mesh) -> tuple[FloatArray, IntArray]:
    """Return the sign that orients each triangle with its neighbours, and its component, shapes (m,).

    Each triangle stands twice in a graph, once each way up; neighbours are joined the way they fit. A
    component that can be oriented falls into two halves, of which the one with the first triangle as it
    is gives the signs; one that cannot keeps signs of 1.
    """
    m = len(mesh.triangles)
    pair = mesh.joints // 3
    fits = mesh.upward.ravel()[mesh.joints[:, 0]] != mesh.upward.ravel()[mesh.joints[:, 1]]
    part = components(m, pair)
    if fits.all():
        return floats(np.ones(m)), ints(part)
    other = pair[:, 1] + np.where(fits, 0, m)
    both = components(
        2 * m, np.concatenate([np.c_[pair[:, 0], other], np.c_[pair[:, 0] + m, (other + m) % (2 * m)]])
    )
    _, first, part = np.unique(part, return_index=True, return_inverse=True)
    part = part.reshape(-1)
    agrees = both[:m] == both[first][part]
    return floats(np.where(agrees, 1.0, -1.0)), ints(part)


@dataclass(frozen=True, eq=False)
class Doubled:
    """The faces of a view that triangles cover more than once.

    Parameters
    ----------
    faces : (k,) array of shapely polygons
        Empty where every place is covered at most once.
    tangled : bool
        True where the lines that bound the coverage meet so often that it was not worked out.
    """

    faces: NDArray[np.object_]
    tangled: bool = False


def doubled(points: FloatArray, mesh: Mesh) -> Doubled:
    """Return the faces of the plane that the triangles of a mesh cover more than once.

    With every triangle turned counter-clockwise, the winding number of the boundary of their sum about a
    place is the number of triangles over it. So only the faces between the boundary lines are looked at,
    one point each.

    Parameters
    ----------
    points : (n, 2) array
        The vertices in plan, or in another view.
    mesh : Mesh
        Their triangles.
    """
    none = np.zeros(0, dtype=np.object_)
    ends = _outline(points, mesh)
    if not len(ends):
        return Doubled(none)
    lines = shapely.linestrings(ends)
    if _meetings(lines) > MEETINGS_EACH * len(lines) + MEETINGS_FREE:
        return Doubled(none, tangled=True)
    area = 0.5 * float(np.abs(_turns(points, mesh.triangles)).sum())
    # lines upon lines may leave a face open, so that areas are missing; on a grid they become one, at a cost
    for grid in (None, GRID * float(np.ptp(ends.reshape(-1, 2), axis=0).max())):
        faces = shapely.get_parts(shapely.polygonize([shapely.union_all(lines, grid_size=grid)]))
        times = winding_numbers(shapely.get_coordinates(shapely.point_on_surface(faces)), ends)
        if abs(float((times * shapely.area(faces)).sum()) - area) <= CLOSED * area:
            return Doubled(faces[times > 1])
    return Doubled(none, tangled=True)


def narrowest_overlap(surface: Surface, plan: Projection) -> float:
    """Return the width up to which an overlap in plan is a matter of rounding, model units.

    Where there are vertical triangles: as well up to what the surface can lean back through them.
    """
    mesh = welded_mesh_of(surface)
    if not len(mesh.edges):
        return 0.0
    ends = surface.vertices[mesh.edges]
    step = float(np.hypot(*(ends[:, 1] - ends[:, 0])[:, :2].T).mean())
    height = float(np.ptp(ends[:, :, 2])) if len(plan.vertical) else 0.0
    return max(OVERLAP_WIDTH * step, height / float(np.tan(np.radians(VERTICAL))))


@remembered
def doubled_in_plan(surface: Surface) -> Doubled:
    """Return the faces of the plan that a surface covers more than once, see :func:`doubled`.

    Vertices at one place count as one, and triangles on the same places too: they are no overlap.
    """
    return doubled(surface.vertices[:, :2], welded_mesh_of(surface))


def covers_once(surface: Surface, least: float) -> bool:
    """Return whether a surface covers every place of the plan at most once, as far as is cheaply told.

    Faces that are covered twice count where their mean width is above ``least``, model units. False as
    well where the surface is so tangled that its faces are not worked out.
    """
    found = doubled_in_plan(surface)
    wide = 2.0 * shapely.area(found.faces) > least * shapely.length(found.faces)
    return not (found.tangled or wide.any())


def _outline(points: FloatArray, mesh: Mesh) -> FloatArray:
    """Return the directed edges that bound the sum of the triangles in a view, each as often as it counts.

    Every triangle counts counter-clockwise; shape (b, 2, 2).
    """
    ccw = np.sign(_turns(points, mesh.triangles))[:, None] * np.where(mesh.upward, 1.0, -1.0)
    net = np.bincount(mesh.sides.ravel(), ccw.ravel(), minlength=len(mesh.edges)).astype(int)
    bounding = np.flatnonzero(net)
    net, edges = net[bounding], mesh.edges[bounding]
    directed = np.where((net < 0)[:, None], edges[:, ::-1], edges)
    return np.asarray(points[np.repeat(directed, np.abs(net), axis=0)], dtype=np.float64).reshape(-1, 2, 2)


def _turns(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Return twice the area of triangles in a view, shape (m,), positive where they run counter-clockwise."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.asarray((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))


def _meetings(lines: NDArray[np.object_]) -> int:
    """Return how often the boxes of lines meet, each pair twice; counting ends where it is too often."""
    tree = shapely.STRtree(lines)
    count = 0
    for start in range(0, len(lines), LINES_AT_ONCE):
        count += tree.query(lines[start : start + LINES_AT_ONCE]).shape[1]
        if count > MEETINGS_EACH * len(lines) + MEETINGS_FREE:
            break
    return count


def winding_numbers(points: FloatArray, ends: FloatArray) -> IntArray:
    """Return how often closed lines, given by directed segments (b, 2, 2), go round points (p, 2).

    >>> corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    >>> square = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    >>> winding_numbers(floats([[0.5, 0.5], [2, 0]]), square).tolist()
    [1, 0]
    """
    (ax, ay), (bx, by) = ends[:, 0].T, ends[:, 1].T
    counts = [np.zeros(0, dtype=np.int64)]
    for chunk in np.array_split(points, len(points) * len(ends) // PRODUCTS_AT_ONCE + 1):
        x, y = chunk[:, :1], chunk[:, 1:]
        left = (bx - ax) * (y - ay) - (x - ax) * (by - ay)
        rising: BoolArray = (ay <= y) & (by > y) & (left > 0)
        falling: BoolArray = (ay > y) & (by <= y) & (left < 0)
        counts.append(rising.sum(axis=1) - falling.sum(axis=1))
    return ints(np.concatenate(counts))
