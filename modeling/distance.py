"""Plan distances to the cut graph."""

from __future__ import annotations

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray
from graben.cutgraph import CutGraph
from graben.proximity import nearest


def distances(
    points: FloatArray, graph: CutGraph, edges: BoolArray | None = None
) -> tuple[FloatArray, IntArray]:
    """Return the plan distance of points to the cut graph and the index of the nearest of its edges.

    Parameters
    ----------
    points : (n, 2) array
        Plan positions, model units.
    graph : CutGraph
        The cut graph.
    edges : (e,) bool array, optional
        Which of its edges count; default all. With none, the distances are infinite.
    """
    chosen = np.arange(len(graph.edges)) if edges is None else np.flatnonzero(edges)
    if len(chosen) == 0:
        return np.full(len(points), np.inf), np.full(len(points), -1, dtype=np.int64)
    near = nearest(points[:, :2], graph.nodes, graph.edges[chosen])
    return near.distance, chosen[near.simplex]


def outside(points: FloatArray, graph: CutGraph, gammas: FloatArray) -> FloatArray:
    """Return how far points lie outside the zone, (n,), negative inside: min over i of d_i - gamma_i.

    Parameters
    ----------
    points : (n, 2) array
        Plan positions, model units.
    graph : CutGraph
        The cut graph, with at least one edge.
    gammas : (f,) array
        gamma of each fault in ``np.unique(graph.faults)``, model units.
    """
    faults = np.unique(graph.faults)
    parts = [
        distances(points, graph, np.isin(graph.faults, faults[gammas == g]))[0] - g for g in np.unique(gammas)
    ]
    return np.asarray(np.min(parts, axis=0), dtype=np.float64)
