"""acyclic: the cut graph has no cycle (paper Sect. 3.3)."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.cutgraph import CutGraph
from graben.validators.context import Check, CheckContext, Defect, Need, Severity
from graben.validators.measures import components, plural


def _run(context: CheckContext) -> list[Defect]:
    names = [f.name for f in context.model.faults]
    anchors = context.evidence.anchors
    found = []
    for horizon, graph in context.traced():
        cycles = fundamental_cycles(graph)
        if not cycles:
            continue
        held = horizon.name in anchors and all(a.holds for a in anchors[horizon.name])
        lengths = [_length(graph.nodes[c]) for c in cycles]
        nodes = np.unique(np.concatenate(cycles))
        on_it = np.isin(graph.edges, nodes).all(axis=1)
        closing = ", ".join(names[k] for k in np.unique(graph.faults[on_it]))
        found.append(
            Defect(
                (horizon.name,),
                f"The cut graph of {horizon.name} has {plural(len(cycles), 'cycle')}, closed by {closing}.",
                "Leave a gap in one of the faults of the cycle"
                + (
                    ": each part has fixed nodes enough to be modeled."
                    if held
                    else ", or reduce gamma there."
                ),
                count=len(cycles),
                value=min(lengths),
                unit=context.unit,
                place=_middle(graph.nodes[cycles[int(np.argmin(lengths))]]),
                elements=ints(nodes),
                places=floats(graph.nodes[nodes], -1, 3),
                severity=Severity.RELAXED if held else Severity.FAIL,
            )
        )
    return found


def fundamental_cycles(graph: CutGraph) -> list[IntArray]:
    """Return a basis of the cycles of a cut graph: node indices along each, the first not repeated.

    An edge that belongs to two faults counts once. Each edge outside a breadth-first forest closes one
    cycle: with the two ways from its ends to their common ancestor.
    """
    count = len(graph.nodes)
    pairs = np.sort(graph.edges, axis=1)
    pairs = np.unique(pairs[pairs[:, 0] != pairs[:, 1]], axis=0)
    if not len(pairs):
        return []
    parent = np.full(count, -1, dtype=np.int64)
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count)).tocsr()
    roots = np.unique(components(count, pairs), return_index=True)[1]
    for root in roots[np.isin(roots, pairs)]:
        order, before = breadth_first_order(links, root, directed=False)
        parent[order[1:]] = before[order[1:]]
    in_forest = (parent[pairs[:, 0]] == pairs[:, 1]) | (parent[pairs[:, 1]] == pairs[:, 0])
    return [_closed(parent, int(a), int(b)) for a, b in pairs[~in_forest]]


def _closed(parent: IntArray, a: int, b: int) -> IntArray:
    """Return the cycle that the edge (a, b) closes in a forest given by the parent of each node."""
    ways = []
    for node in (a, b):
        way = [node]
        while parent[way[-1]] >= 0:
            way.append(int(parent[way[-1]]))
        ways.append(way)
    common = set(ways[1])
    up = next(k for k, node in enumerate(ways[0]) if node in common)
    down = ways[1].index(ways[0][up])
    return ints(ways[0][: up + 1] + ways[1][:down][::-1])


def _length(points: FloatArray) -> float:
    """Return the length in plan of a closed polyline."""
    return float(np.linalg.norm((np.roll(points, -1, axis=0) - points)[:, :2], axis=1).sum())


def _middle(points: FloatArray) -> FloatArray:
    """Return the node of a cycle nearest to the middle of its nodes, so that the place is on a cut."""
    return np.asarray(points[np.argmin(np.linalg.norm(points - points.mean(axis=0), axis=1))])


CHECK = Check(
    "acyclic",
    "3.3",
    "The cut graph of each horizon has no cycle.",
    need=Need.GRAPH,
    stage=Need.ANCHORS,
    run=_run,
)
