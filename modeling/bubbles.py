"""Bubbles: parts of a horizon of a few cells that the trace of one fault closes off alone.

Near a fault a horizon is smeared, noisy or drawn as a step over one cell, and may cross the fault a few times
more than the beds did. What is cut out so holds hardly a node, and no fixed one: it can neither be held nor
moved, and lies inside the zone that is rebuilt all the same. The trace goes on past it along the shorter way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import shapely

from graben.arrays import FloatArray, IntArray, ints
from graben.modeling.resampling import Trace
from graben.refinement import component_labels

#: Faces smaller than so many cells of the horizon are bubbles: a circle three steps wide.
_CELLS = 8.0


def unbubbled(trace: Trace, step: float) -> tuple[Trace, list[tuple[int, FloatArray, float]]]:
    """Return the trace without bubbles, and of each its fault, its middle (3,) and the length left out.

    A ring that stands alone, or hangs on the rest by one point, goes as a whole; of one in two points, the
    longer way round goes. A ring that joins more than two others stays, as do those of several faults.

    Parameters
    ----------
    trace : Trace
        As of :func:`graben.modeling.snapping.snapped`.
    step : float
        Of the horizon, model units.
    """
    left: list[tuple[int, FloatArray, float]] = []
    for fault in np.unique(trace.faults).tolist():
        while _has_cycle(trace, fault):
            found = next(_bubbles(trace, fault, _CELLS * step**2), None)
            if found is None:
                break
            gone, middle = found
            left.append((fault, middle, float(_lengths(trace)[gone].sum())))
            kept = np.setdiff1d(np.arange(len(trace.edges)), gone)
            trace = replace(trace, edges=trace.edges[kept], faults=trace.faults[kept], rim=trace.rim[kept])
    return trace, left


def _has_cycle(trace: Trace, fault: int) -> bool:
    """Return whether the trace of a fault closes on itself anywhere (Euler)."""
    edges = np.unique(np.sort(trace.edges[trace.faults == fault], axis=1), axis=0)
    nodes, local = np.unique(edges, return_inverse=True)
    labels = component_labels(len(nodes), local.reshape(-1, 2))
    return len(edges) > len(nodes) - (int(labels.max(initial=-1)) + 1)


def _bubbles(trace: Trace, fault: int, most: float) -> Iterator[tuple[IntArray, FloatArray]]:
    """Yield the edges to leave out of each bubble smaller than ``most``, and its middle, smallest first."""
    mine = np.flatnonzero(trace.faults == fault)
    plan = trace.points[:, :2]
    faces = shapely.get_parts(shapely.polygonize(shapely.linestrings(plan[trace.edges[mine]])))
    areas = shapely.area(faces)
    at = {(x, y): k for k, (x, y) in enumerate(plan.tolist())}
    edge_of = {
        (min(a, b), max(a, b)): e for e, (a, b) in zip(mine.tolist(), trace.edges[mine].tolist(), strict=True)
    }
    for k in np.argsort(areas, kind="stable").tolist():
        if areas[k] >= most:
            return
        ring = [at[x, y] for x, y in faces[k].exterior.coords[:-1]]
        edges = [edge_of[min(a, b), max(a, b)] for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)]
        gone = _to_leave_out(trace, ring, edges)
        if len(gone):
            yield gone, trace.points[ring].mean(axis=0)


def _to_leave_out(trace: Trace, ring: list[int], edges: list[int]) -> IntArray:
    """Return the edges of a ring to leave out: all, the longer of its two ways, or none.

    ``edges`` has for each node of ``ring`` the edge that leads on from it.
    """
    own = np.zeros(len(trace.edges), dtype=bool)
    own[edges] = True
    degree = np.bincount(trace.edges[~own].ravel(), minlength=len(trace.points))
    held = [k for k, node in enumerate(ring) if degree[node]]
    if len(held) < 2:
        return ints(edges)
    if len(held) > 2:
        return ints([])
    ways = [edges[held[0] : held[1]], edges[held[1] :] + edges[: held[0]]]
    lengths = _lengths(trace)
    return ints(max(ways, key=lambda way: float(lengths[way].sum())))


def _lengths(trace: Trace) -> FloatArray:
    """Return the length of each edge in plan, (e,)."""
    ends = trace.points[trace.edges][:, :, :2]
    return np.asarray(np.hypot(*(ends[:, 1] - ends[:, 0]).T), dtype=np.float64)
