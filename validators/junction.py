"""junction: two faults meet on a horizon in points only (paper Sect. 3.2, condition 4)."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from graben.arrays import IntArray, floats, ints
from graben.cutgraph import CutGraph
from graben.finding import Element
from graben.validators.context import Check, CheckContext, Defect, Need, Scope
from graben.validators.measuring.measures import amount
from graben.validators.measuring.trace_measures import pieces
from graben.words import plural


def _run(context: CheckContext) -> list[Defect]:
    names = [f.name for f in context.model.faults]
    return [
        _defect(graph, edges, (h.name, names[i], names[j]), context.unit)
        for h, graph in context.traced()
        for (i, j), edges in common_edges(graph).items()
    ]


def common_edges(graph: CutGraph) -> dict[tuple[int, int], IntArray]:
    """Return for each pair of faults that share edges of a cut graph these edges, by index in the first."""
    which = np.unique(np.sort(graph.edges, axis=1), axis=0, return_inverse=True)[1].reshape(-1)
    shared = np.flatnonzero(np.bincount(which, minlength=1)[which] > 1) if len(which) else which
    found: dict[tuple[int, int], list[int]] = {}
    for group in np.unique(which[shared]):
        same = shared[which[shared] == group]
        owners = sorted({int(graph.faults[e]): int(e) for e in same}.items())
        for (i, edge), (j, _) in combinations(owners, 2):
            found.setdefault((i, j), []).append(edge)
    return {pair: ints(found[pair]) for pair in sorted(found)}


def _defect(graph: CutGraph, edges: IntArray, objects: tuple[str, str, str], unit: str) -> Defect:
    """Return the stretches along which two faults run together on a horizon."""
    stretches = pieces(graph, edges)
    total = sum(stretch.length for stretch in stretches)
    over = amount(total, unit)
    where = f", in {plural(len(stretches), 'stretch', 'stretches')}" if len(stretches) > 1 else ""
    return Defect(
        objects,
        f"{objects[1]} and {objects[2]} run together on {objects[0]} over {over}{where}.",
        "Let the two faults cross at an angle, or end one at the other.",
        count=len(stretches),
        value=total,
        unit=unit,
        place=stretches[0].middle,
        elements=_ends(graph.edges[edges]),
        element=Element.NODE,
        places=floats([stretch.middle for stretch in stretches], -1, 3),
        paths=tuple(path for stretch in stretches for path in stretch.paths),
        parts=tuple(stretch.part("common stretch", unit) for stretch in stretches),
        blocks=True,
    )


def _ends(edges: IntArray) -> IntArray:
    """Return the nodes at which stretches of edges (e, 2) begin, end or branch."""
    nodes, count = np.unique(edges, return_counts=True)
    return ints(nodes[count != 2])


CHECK = Check(
    "junction",
    "3.2, condition 4",
    "Two faults meet on a horizon in points only.",
    "Along an edge that two faults share a cut node would have to lie on both at once while it moves.",
    _run,
    need=Need.GRAPH,
    scope=Scope.HORIZON,
)
