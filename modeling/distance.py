"""Plan distances to the cut graph."""

from __future__ import annotations

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.cutgraph import CutGraph
from graben.proximity import boxes_over, nearest


def distances(
    points: FloatArray, graph: CutGraph, edges: BoolArray | None = None, within: float = np.inf
) -> tuple[FloatArray, IntArray]:
    """Return the plan distance of points to the cut graph and the index of the nearest of its edges.

    Parameters
    ----------
    points : (n, 2) array
        Plan positions, model units.
    graph : CutGraph
        The cut graph.
    edges : (e,) bool array, optional
        Which of its edges count; default all. With none, the distances are infinite, the edges -1.
    within : float
        Points that are certainly further away are not asked for: the same stands for them, model units.
    """
    chosen = np.arange(len(graph.edges)) if edges is None else np.flatnonzero(edges)
    if len(chosen) == 0:
        return np.full(len(points), np.inf), np.full(len(points), -1, dtype=np.int64)
    if np.isinf(within):
        near = nearest(points[:, :2], graph.nodes, graph.edges[chosen])
        return near.distance, chosen[near.simplex]
    away, edge = np.full(len(points), np.inf), np.full(len(points), -1, dtype=np.int64)
    a, b = graph.nodes[graph.edges[chosen, 0], :2], graph.nodes[graph.edges[chosen, 1], :2]
    over = boxes_over(points, points, np.minimum(a, b) - within, np.maximum(a, b) + within)
    away[over], edge[over] = distances(points[over], graph, edges)
    return away, edge


def outside(points: FloatArray, graph: CutGraph, gammas: FloatArray, within: float = np.inf) -> FloatArray:
    """Return how far points lie outside the zone, (n,), negative inside: min over i of d_i - gamma_i.

    Parameters
    ----------
    points : (n, 2) array
        Plan positions, model units.
    graph : CutGraph
        The cut graph, with at least one edge.
    gammas : (f,) array
        gamma of each fault in ``np.unique(graph.faults)``, model units.
    within : float
        Points that certainly lie further outside are not asked for: infinity stands for them, model units.
    """
    faults = np.unique(graph.faults)
    parts = [
        distances(points, graph, np.isin(graph.faults, faults[gammas == g]), g + within)[0] - g
        for g in np.unique(gammas)
    ]
    return np.asarray(np.min(parts, axis=0), dtype=np.float64)
