"""The initial triangulation T_0 of a horizon with the cut graph as constraints (paper Sect. 4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import triangle
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray, bools, floats, ints
from graben.cutgraph import CutGraph, NodeKind
from graben.errors import ModelingError
from graben.modeling.distance import distances
from graben.modeling.snapping import NEAR
from graben.modeling.zone import CLEARANCE, zone_of
from graben.proximity import Simplices, boxes, boxes_over, nearest
from graben.surface import Surface, boundary_edges, edge_sharing, edge_table

#: Width of the band around the cut that is triangulated anew, in steps.
_BAND = 2.5
#: A centre off the region by less than this share of its triangle's longest side lies in it.
_ON = 1e-6
#: Triangles flatter than this (double area over the square of the longest side) are none.
_FLAT = 1e-9


@dataclass(frozen=True, eq=False)
class PlanMesh:
    """A triangulation in plan that contains the cut graph.

    Parameters
    ----------
    points : (n, 3) array
        x, y and the elevation of the input horizon. The nodes of the cut graph come first, in its order.
    triangles : (m, 3) array
        Counter-clockwise in plan.
    cut : (e, 2) array
        The edges of the cut graph, node indices.
    outer : (n,) bool array
        Nodes on the boundary of the horizon.
    """

    points: FloatArray
    triangles: IntArray
    cut: IntArray
    outer: BoolArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", floats(self.points, -1, 3))
        object.__setattr__(self, "triangles", ints(self.triangles, -1, 3))
        object.__setattr__(self, "cut", ints(self.cut, -1, 2))
        object.__setattr__(self, "outer", bools(self.outer))


def triangulated(horizon: Surface, graph: CutGraph, step: float, gammas: FloatArray) -> PlanMesh:
    """Return the input triangulation with a band around the cut triangulated anew.

    Outside the band the input's own triangles are kept, so that the horizon is not resampled there. In
    the band: a constrained Delaunay triangulation of the nodes of the cut, of the band's rim and of the
    input's nodes that are not too close to the cut.

    Parameters
    ----------
    horizon : Surface
        A function of x and y.
    graph : CutGraph
        Its cut graph; without edges the input triangulation is returned.
    step : float
        Model units.
    """
    faces = upward(horizon.vertices, horizon.triangles)
    vertices = horizon.vertices
    outer = np.zeros(len(vertices), dtype=bool)
    outer[horizon.rim] = True
    if len(graph.edges) == 0:
        return PlanMesh(vertices, faces, np.zeros((0, 2), dtype=np.int64), outer)
    band = max(gammas.max(), 0.0) + _BAND * step
    redo = (distances(vertices, graph, within=band)[0] < band)[faces].any(axis=1)
    redo |= _crossed(vertices, faces, graph, step)
    rim = boundary_edges(faces[redo])
    on_rim = np.zeros(len(vertices), dtype=bool)
    on_rim[rim] = True
    inside = np.zeros(len(vertices), dtype=bool)
    inside[faces[redo]] = True
    old = Simplices(vertices[:, :2], faces[redo])
    zone = zone_of(horizon, faces[redo], graph, step, gammas, old)
    fill = np.concatenate([zone.ring, zone.inner])
    fill = fill[cKDTree(vertices[on_rim, :2]).query(fill[:, :2])[0] > CLEARANCE * step]
    free = inside & ~on_rim & zone.beyond
    count = len(graph.nodes)
    rim, gone = _with_exits(vertices, rim, outer, graph, step)
    chosen = np.flatnonzero(free | (on_rim & ~gone))
    index = np.full(len(vertices) + count, -1)
    index[chosen] = count + np.arange(len(chosen))
    index[len(vertices) :] = np.arange(count)
    points = np.concatenate([graph.nodes, vertices[chosen], fill])
    new = _constrained(points[:, :2], np.concatenate([graph.edges, index[rim]]))
    new = new[_inside(points, new, old)]
    kept = np.flatnonzero(~redo)
    used = np.zeros(len(vertices), dtype=bool)
    used[faces[kept]] = True
    used[chosen] = False
    others = np.flatnonzero(used)
    index[others] = len(points) + np.arange(len(others))
    triangles = np.concatenate([new, index[faces[kept]]])
    border = np.concatenate(
        [graph.kinds == NodeKind.EXIT, outer[chosen], np.zeros(len(fill), dtype=bool), outer[others]]
    )
    whole = np.concatenate([points, vertices[others]])
    exits = graph.nodes[graph.kinds == NodeKind.EXIT]
    triangles = _without_ears(whole, triangles, border, exits, graph.edges, float(gammas.max()))
    return PlanMesh(whole, triangles, graph.edges, border)


def _without_ears(
    points: FloatArray, triangles: IntArray, outer: BoolArray, exits: FloatArray, cut: IntArray, reach: float
) -> IntArray:
    """Return the triangles with those in corners of the outline turned so that none has only outer nodes.

    Where an exit moves round a corner, the nodes between slide along the outline (paper Sect. 5), and a
    triangle of three of them would come to lie on one straight side. ``exits`` (x, 3): within ``reach`` of
    these.
    """
    if len(exits) == 0:
        return triangles
    ears = np.flatnonzero(outer[triangles].all(axis=1))
    ears = ears[cKDTree(exits[:, :2]).query(points[triangles[ears], :2])[0].min(axis=1) <= reach]
    if len(ears) == 0:
        return triangles
    edges, sides = edge_table(triangles)
    sharing = edge_sharing(sides, len(edges))
    held = {(min(a, b), max(a, b)) for a, b in cut.tolist()}
    result = triangles.copy()
    for t in ears:
        inner = np.flatnonzero(sharing[sides[t]] == 2)
        if len(inner) != 1 or tuple(edges[sides[t, inner[0]]].tolist()) in held:
            continue
        other = next(o for o in np.flatnonzero((sides == sides[t, inner[0]]).any(axis=1)) if o != t)
        corner = triangles[t, inner[0]]
        a, b = triangles[t, (inner[0] + 1) % 3], triangles[t, (inner[0] + 2) % 3]
        far = next(int(n) for n in triangles[other] if n not in (a, b))
        new = ints([[corner, a, far], [corner, far, b]])
        if not outer[far] and (_double_areas(points, new) > 0).all():
            result[t], result[other] = new
    return result


def _double_areas(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Return twice the plan areas of triangles, (m,), positive for those counter-clockwise."""
    a, b, c = (points[triangles[:, k], :2] for k in range(3))
    return np.asarray((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))


def upward(vertices: FloatArray, triangles: IntArray) -> IntArray:
    """Return the triangles turned counter-clockwise in plan."""
    turned = _double_areas(vertices, triangles) < 0
    return ints(np.where(turned[:, None], triangles[:, ::-1], triangles))


def _crossed(vertices: FloatArray, faces: IntArray, graph: CutGraph, step: float) -> BoolArray:
    """Return which triangles hold a point of the cut: large triangles may have all corners far from it."""
    ends = graph.nodes[graph.edges][:, :, :2]
    parts = max(2, int(np.ceil(2 * np.hypot(*(ends[:, 1] - ends[:, 0]).T).max() / step)))
    share = np.linspace(0.0, 1.0, parts + 1)[:, None, None]
    points = (ends[:, 0] * (1 - share) + ends[:, 1] * share).reshape(-1, 2)
    # the cut lies on the horizon to rounding: no triangle further off than a step can hold one
    low, high = boxes(vertices, faces)
    close = np.flatnonzero(boxes_over(low - step, high + step, points, points))
    found = np.zeros(len(faces), dtype=bool)
    found[close[nearest(points, vertices, faces[close]).simplex]] = True
    return found


def _with_exits(
    vertices: FloatArray, rim: IntArray, outer: BoolArray, graph: CutGraph, step: float
) -> tuple[IntArray, BoolArray]:
    """Return the rim with each exit put into the boundary edge it lies on, and the nodes that made way.

    A boundary node that is in line with its neighbours and close to an exit is left out, and any that the
    exit cannot be told from. Exits are numbered from ``len(vertices)``, as the nodes of the graph.
    """
    rim = rim.copy()
    gone = np.zeros(len(vertices), dtype=bool)
    at = np.concatenate([vertices[:, :2], graph.nodes[:, :2]])
    for exit_node in np.flatnonzero(graph.kinds == NodeKind.EXIT):
        p = graph.nodes[exit_node, :2]
        node = len(vertices) + exit_node
        border = np.flatnonzero(np.append(outer, np.ones(len(graph.nodes), bool))[rim].all(axis=1))
        a, b = at[rim[border, 0]], at[rim[border, 1]]
        way = b - a
        share = np.clip(
            ((p - a) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), np.finfo(float).tiny), 0, 1
        )
        k = border[np.argmin(((a + share[:, None] * way - p) ** 2).sum(axis=1))]
        start, end = rim[k]
        straight = {near: _is_straight(rim, near, at) for near in (start, end)}
        rim = np.concatenate([np.delete(rim, k, axis=0), [[start, node], [node, end]]])
        for near in (start, end):
            away = np.hypot(*(at[near] - p))
            if near < len(vertices) and away < CLEARANCE * step / 2:
                mine = np.flatnonzero((rim == near).any(axis=1))
                # An exit in a corner, to rounding, is the corner.
                if len(mine) == 2 and (straight[near] or away <= NEAR * step):
                    before = rim[mine[rim[mine, 1] == near][0], 0]
                    after = rim[mine[rim[mine, 0] == near][0], 1]
                    rim = np.concatenate([np.delete(rim, mine, axis=0), [[before, after]]])
                    gone[near] = True
    return rim, gone


def _is_straight(rim: IntArray, node: int, at: FloatArray) -> bool:
    """Return whether a node of the rim lies in line with the two beside it."""
    mine = rim[(rim == node).any(axis=1)]
    far = mine[mine != node]
    return len(far) == 2 and _in_line(at[far[0]], at[node], at[far[1]])


def _in_line(a: FloatArray, b: FloatArray, c: FloatArray) -> bool:
    """Return whether b lies on the segment from a to c, to rounding."""
    first, second = b - a, c - b
    cross = abs(first[0] * second[1] - first[1] * second[0])
    return bool(cross <= 1e-6 * np.hypot(*first) * np.hypot(*second))


def _constrained(points: FloatArray, segments: IntArray) -> IntArray:
    """Return the constrained Delaunay triangulation inside closed segments, counter-clockwise, (m, 3).

    Holes are filled.
    """
    made = triangle.triangulate({"vertices": np.array(points), "segments": segments.astype(np.int32)}, "p")
    if len(made["vertices"]) != len(points):
        raise ModelingError("The cut graph crosses itself in plan after resampling; use a smaller step.")
    return np.asarray(made["triangles"], dtype=np.int64)


def _inside(points: FloatArray, new: IntArray, old: Simplices) -> BoolArray:
    """Return which new triangles lie in the region of the old ones, by their centres."""
    away = old.nearest(points[new][:, :, :2].mean(axis=1)).distance
    area = _double_areas(points, new)
    a, b, c = (points[new[:, k], :2] for k in range(3))
    longest = np.max(
        [((a - b) ** 2).sum(axis=1), ((b - c) ** 2).sum(axis=1), ((c - a) ** 2).sum(axis=1)], axis=0
    )
    return np.asarray((away**2 <= _ON**2 * longest) & (area > _FLAT * longest), dtype=bool)
