"""Cutoff lines with throw and heave, from the two lips of each fault."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graben.arrays import FloatArray, IntArray
from graben.cutgraph import CutGraph
from graben.modeling.cutting import CutMesh
from graben.modeling.results import Cutoff
from graben.proximity import nearest
from graben.surface import Surface, chained, mean_dip_direction, triangle_normals


def cutoffs(
    graph: CutGraph, cut: CutMesh, points: FloatArray, faults: Sequence[Surface]
) -> tuple[Cutoff, ...]:
    """Return the cutoff lines of every piece of every fault on a rebuilt horizon.

    A tip stands as a pair of equal points, a junction once for each side of the other fault.

    Parameters
    ----------
    graph : CutGraph
        The cut graph; its edges run with the dip to their right.
    cut : CutMesh
        The opened triangulation.
    points : (n, 3) array
        Where its copies lie in the end, model units.
    faults : sequence of Surface
        The model's faults.
    """
    found: list[Cutoff] = []
    for f in np.unique(graph.faults):
        mine = np.flatnonzero(graph.faults == f)
        dips = _dip_directions(faults[f], graph.nodes)
        for path in paths(graph.edges[mine]):
            edges = mine[path]
            foot = np.ravel(cut.left[edges])
            hanging = np.ravel(cut.right[edges])
            nodes = np.ravel(graph.edges[edges])
            way = np.hypot(
                *(graph.nodes[graph.edges[edges, 1]] - graph.nodes[graph.edges[edges, 0]])[:, :2].T
            )
            end = np.cumsum(way)
            # Both rows of a junction have the same s, to the bit.
            s = np.ravel(np.stack([np.append(0.0, end[:-1]), end], axis=1))
            # The pair at the end of an edge is that at the start of the next, but at junctions.
            new = np.append(True, (hanging[1:] != hanging[:-1]) | (foot[1:] != foot[:-1]))
            h, t, s, nodes = points[hanging[new]], points[foot[new]], s[new], nodes[new]
            heave = ((h - t)[:, :2] * dips[nodes]).sum(axis=1)
            found.append(Cutoff(faults[f].name, s, h, t, t[:, 2] - h[:, 2], heave))
    return tuple(found)


def paths(edges: IntArray) -> list[IntArray]:
    """Return the edges (e, 2) of one fault as paths of edge indices in their own direction.

    The cutoffs of the fault are its paths in this order.
    """
    base = int(edges.max()) + 1
    index = {int(a) * base + int(b): k for k, (a, b) in enumerate(edges)}
    found = []
    for chain in chained(edges):
        a, b = chain[:-1].tolist(), chain[1:].tolist()
        if a[0] * base + b[0] not in index:
            a, b = b[::-1], a[::-1]
        found.append(np.array([index[i * base + j] for i, j in zip(a, b, strict=True)]))
    return sorted(found, key=lambda path: int(path.min()))


def _dip_directions(fault: Surface, nodes: FloatArray) -> FloatArray:
    """Return the plan dip direction of the fault at points on it, unit vectors, shape (n, 2)."""
    near = nearest(nodes, fault.vertices, fault.triangles).simplex
    normals = triangle_normals(fault.vertices, fault.triangles)[near]
    mean = mean_dip_direction(fault.vertices, fault.triangles)[0]
    plan = normals[:, :2] * np.where(normals[:, 2] < 0, -1.0, 1.0)[:, None]
    # Vertical or overturned triangles: the side towards which the fault as a whole dips.
    plan = plan * np.where(plan @ mean < 0, -1.0, 1.0)[:, None]
    size = np.hypot(*plan.T)[:, None]
    return np.where(size > 0, plan / np.where(size > 0, size, 1.0), mean)
