"""An exact trace brought to a least distance between its points, which a mesh can resolve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.modeling.resampling import Trace
from graben.proximity import nearest
from graben.refinement import component_labels
from graben.surface import Surface

#: Points of a trace nearer than this many steps to each other, or to the boundary, are one.
NEAR = 1e-3
#: Two faults that share edges over less than this many steps cross there in one point.
_TOGETHER = 0.5


def snapped(trace: Trace, step: float) -> Trace:
    """Return a trace in which no two points, and no point and edge, are nearer in plan than NEAR steps.

    Exact intersections of surfaces that nearly share points leave points and edges a rounding error apart,
    between which no triangle fits: three faults through one point, a fault that ends at another to the
    digits of its file, a horizon node on a fault, a fault given twice. Points of a group become one of
    them, and an edge is led through a point close to it. A group is never wider than the least distance: a
    line of many short edges keeps its course. Where two faults cross at a small angle they then share a few
    short edges, which become the one point in which they cross.

    Parameters
    ----------
    trace : Trace
        The exact intersection.
    step : float
        Of the horizon, model units.
    """
    close = _through_points(_merged(trace, NEAR * step), NEAR * step)
    return _contracted(close, _TOGETHER * step)


def _merged(trace: Trace, reach: float) -> Trace:
    """Return the trace with points closer than ``reach`` made one."""
    target = _targets(trace, reach)
    return trace if target is None else _joined(trace, target)


def _joined(trace: Trace, target: IntArray) -> Trace:
    """Return the trace with each point replaced by its target, and edges that collapse left out."""
    outer = trace.outer.copy()
    np.maximum.at(outer, target, trace.outer)
    at = target[trace.edges]
    on_rim = _keys(trace, at)[trace.rim == 1]
    whole = at[:, 0] != at[:, 1]
    return _rebuilt(trace, at[whole], trace.faults[whole], outer, on_rim)


def _contracted(trace: Trace, span: float) -> Trace:
    """Return the trace with edges that several faults share, in groups shorter than ``span``, made points."""
    rows, count = np.unique(np.sort(trace.edges, axis=1), axis=0, return_counts=True)
    shared = rows[count > 1]
    if len(shared) == 0:
        return trace
    labels = component_labels(len(trace.points), shared)
    target = np.arange(len(trace.points))
    for label in np.unique(labels[shared]):
        _together(target, trace, np.flatnonzero(labels == label), span)
    return _joined(trace, target)


def _together(target: IntArray, trace: Trace, group: IntArray, span: float) -> None:
    """Set the target of a group of points less than ``span`` wide to the one nearest to its middle."""
    plan = trace.points[group, :2]
    if np.hypot(*np.ptp(plan, axis=0)) < span:
        off = np.hypot(*(plan - plan.mean(axis=0)).T)
        target[group] = group[np.lexsort((off, _rank(trace)[group]))[0]]


def unlooped(trace: Trace, step: float) -> tuple[Trace, IntArray]:
    """Return the trace with loops less than a step wide made points, and the edges that went with them.

    Where three faults cross nearly in one point, or two near the boundary, they cut out a part of the horizon
    without a node of its own: the mesh can neither hold nor move it, so the faults are drawn as crossing in
    one point. So is a junction that lies right beside an exit. A ring that joins nothing stays.

    Parameters
    ----------
    trace : Trace
        As of :func:`snapped`.
    step : float
        Of the horizon, model units.
    """
    count = len(trace.points)
    rows = np.unique(np.sort(trace.edges, axis=1), axis=0)
    joins = np.concatenate([_around_loops(trace, rows, step), _to_exits(trace, rows, _TOGETHER * step)])
    labels = component_labels(count + int(joins.max(initial=0)), joins)[:count]
    target = np.arange(count)
    degree = np.bincount(rows.ravel(), minlength=count)
    for label in np.unique(labels[joins[joins < count]]):
        group = np.flatnonzero(labels == label)
        if (degree[group] > 2).any():
            _together(target, trace, group, step)
    at = target[trace.edges]
    return _joined(trace, target), np.flatnonzero(at[:, 0] == at[:, 1])


def _around_loops(trace: Trace, rows: IntArray, width: float) -> IntArray:
    """Return pairs (p, 2) of points and loops, numbered after them: the points on and in loops so narrow.

    The boundary closes a loop between exits no further from each other.
    """
    plan = trace.points[:, :2]
    exits = np.intersect1d(np.flatnonzero(trace.outer == 1), rows)
    beside = exits[cKDTree(plan[exits]).query_pairs(width, output_type="ndarray").reshape(-1, 2)]
    lines = plan[np.concatenate([rows, beside])]
    faces = shapely.get_parts(shapely.polygonize(shapely.linestrings(lines)))
    low, high = shapely.bounds(faces).reshape(-1, 2, 2).transpose(1, 0, 2)
    faces = faces[np.hypot(*(high - low).T) < width]
    used = np.unique(rows)
    tree = shapely.STRtree(shapely.points(plan[used]))
    face, point = tree.query(faces, predicate="dwithin", distance=NEAR * width)
    return np.column_stack([used[point], len(plan) + face])


def _to_exits(trace: Trace, rows: IntArray, reach: float) -> IntArray:
    """Return the edges (p, 2) of the ways from exits to junctions within ``reach`` of them."""
    plan, count = trace.points[:, :2], len(trace.points)
    degree = np.bincount(rows.ravel(), minlength=count)
    exits, forks = np.flatnonzero((trace.outer == 1) & (degree > 0)), np.flatnonzero(degree > 2)
    length = np.hypot(*(plan[rows[:, 1]] - plan[rows[:, 0]]).T)
    graph = coo_array((length, tuple(rows.T)), shape=(count, count)).tocsr()
    found = [np.zeros((0, 2), dtype=np.int64)]
    if len(exits) and len(forks):
        away, before = dijkstra(graph, directed=False, indices=exits, limit=reach, return_predecessors=True)
        for k, node in np.argwhere(np.isfinite(away[:, forks])).tolist():
            at = int(forks[node])
            while before[k, at] >= 0:
                found.append(np.array([[at, before[k, at]]]))
                at = int(before[k, at])
    return np.concatenate(found)


def _rank(trace: Trace) -> IntArray:
    """Return which points stay where points are joined: 0 on the boundary, 1 ends and junctions, 2 others."""
    degree = np.bincount(trace.edges.ravel(), minlength=len(trace.points))
    return np.where(trace.outer == 1, 0, np.where(degree != 2, 1, 2))


def _through_points(trace: Trace, reach: float) -> Trace:
    """Return the trace with each edge led through the points closer to it than ``reach``."""
    plan = trace.points[:, :2]
    used = np.unique(trace.edges)
    tree = shapely.STRtree(shapely.linestrings(plan[trace.edges]))
    point, edge = tree.query(shapely.points(plan[used]), predicate="dwithin", distance=reach)
    point = used[point]
    inner = (trace.edges[edge] != point[:, None]).all(axis=1)
    point, edge = point[inner], edge[inner]
    if len(edge) == 0:
        return trace
    start, way = plan[trace.edges[edge, 0]], np.diff(plan[trace.edges[edge]], axis=1)[:, 0]
    share = ((plan[point] - start) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), np.finfo(float).tiny)
    order = np.lexsort((share, edge))
    point, edge = point[order], edge[order]
    cut = np.unique(edge)
    whole = np.setdiff1d(np.arange(len(trace.edges)), cut)
    edges, faults = [trace.edges[whole]], [trace.faults[whole]]
    for e in cut:
        path = np.concatenate([trace.edges[e, :1], point[edge == e], trace.edges[e, 1:]])
        edges.append(np.stack([path[:-1], path[1:]], axis=1))
        faults.append(np.full(len(path) - 1, trace.faults[e]))
    on_rim = _keys(trace, trace.edges)[trace.rim == 1]
    return _rebuilt(trace, np.concatenate(edges), np.concatenate(faults), trace.outer, on_rim)


def _keys(trace: Trace, edges: IntArray, faults: IntArray | None = None) -> IntArray:
    """Return a number for each end of each edge, (e, 2), that tells its fault and its point."""
    faults = trace.faults if faults is None else faults
    return np.asarray(faults[:, None] * len(trace.points) + edges, dtype=np.int64)


def _rebuilt(trace: Trace, edges: IntArray, faults: IntArray, outer: IntArray, on_rim: IntArray) -> Trace:
    """Return a trace of these edges, each once for its fault; ``on_rim`` are the keys of ends on a rim."""
    rows = np.column_stack([faults, np.sort(edges, axis=1)])
    kept = np.sort(np.unique(rows, axis=0, return_index=True)[1])
    rim = np.isin(_keys(trace, edges[kept], faults[kept]), on_rim).astype(np.int64)
    return Trace(trace.points, edges[kept], faults[kept], outer, rim)


def _targets(trace: Trace, reach: float) -> IntArray | None:
    """Return the point that each point becomes, shape (n,); None where all are far enough apart."""
    plan = trace.points[:, :2]
    pairs = cKDTree(plan).query_pairs(reach, output_type="ndarray")
    if len(pairs) == 0:
        return None
    around: dict[int, list[int]] = {}
    for a, b in pairs.tolist():
        around.setdefault(a, []).append(b)
        around.setdefault(b, []).append(a)
    rank = _rank(trace)
    target = np.full(len(plan), -1)
    for node in sorted(around, key=lambda n: (rank[n], *plan[n])):
        if target[node] < 0:
            target[node] = node
            free = [n for n in around[node] if target[n] < 0]
            target[free] = node
    return np.where(target < 0, np.arange(len(plan)), target)


def along_boundary(trace: Trace, horizon: Surface, reach: float) -> BoolArray:
    """Return which edges run along the outer boundary of the horizon in plan, shape (e,).

    Both ends and the middle of such an edge lie within ``reach`` (model units) of the boundary: there is
    nothing on its other side to cut off.
    """
    if len(trace.edges) == 0:
        return np.zeros(0, dtype=bool)
    plan = trace.points[:, :2]
    near = near_boundary(plan, horizon, reach)
    middle = plan[trace.edges].mean(axis=1)
    return np.asarray(near[trace.edges].all(axis=1) & near_boundary(middle, horizon, reach), dtype=bool)


def near_boundary(points: FloatArray, horizon: Surface, reach: float) -> BoolArray:
    """Return which plan points (n, 2) lie within ``reach`` of the horizon's boundary."""
    near = nearest(points[:, :2], horizon.vertices, horizon.rim)
    return np.asarray(near.distance <= reach, dtype=bool)


def reaching(trace: Trace, horizon: Surface, reach: float) -> Trace:
    """Return the trace with ends that stop within ``reach`` of the horizon's boundary counted as on it."""
    degree = np.bincount(trace.edges.ravel(), minlength=len(trace.points))
    ends = np.flatnonzero((degree == 1) & (trace.outer == 0))
    if len(ends) == 0:
        return trace
    outer = trace.outer.copy()
    outer[ends[near_boundary(trace.points[ends, :2], horizon, reach)]] = 1
    return replace(trace, outer=outer)


def without(trace: Trace, gone: BoolArray) -> Trace:
    """Return the trace without some of its edges; what they leave bare on the boundary are exits."""
    outer = trace.outer.copy()
    outer[trace.edges[gone]] = 1
    kept = ~gone
    return replace(
        trace, edges=trace.edges[kept], faults=trace.faults[kept], outer=outer, rim=trace.rim[kept]
    )
