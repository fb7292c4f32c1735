"""junction: two faults meet on a horizon in points only (paper Sect. 3.2, condition 4)."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from graben.arrays import floats, ints
from graben.cutgraph import CutGraph
from graben.validators.context import Check, CheckContext, Defect, Need
from graben.validators.measures import plural


def _run(context: CheckContext) -> list[Defect]:
    names = [f.name for f in context.model.faults]
    return [d for h, graph in context.traced() for d in _shared(graph, h.name, names, context.unit)]


def _shared(graph: CutGraph, horizon: str, names: list[str], unit: str) -> list[Defect]:
    """Return, for each pair of faults, the edges of the cut graph that belong to both."""
    rows = np.unique(np.concatenate([np.sort(graph.edges, axis=1), graph.faults[:, None]], axis=1), axis=0)
    edges, group = np.unique(rows[:, :2], axis=0, return_inverse=True)
    group = group.reshape(-1)
    pairs: dict[tuple[int, int], list[int]] = {}
    for g in np.flatnonzero(np.bincount(group, minlength=len(edges)) > 1):
        owners = rows[group == g, 2].tolist()
        for a, b in pairwise(owners):
            pairs.setdefault((a, b), []).append(int(g))
    return [
        _defect(graph, edges[which], (horizon, names[a], names[b]), unit) for (a, b), which in pairs.items()
    ]


def _defect(
    graph: CutGraph, edges: np.typing.NDArray[np.int64], objects: tuple[str, str, str], unit: str
) -> Defect:
    ends = graph.nodes[edges]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    places = ends.mean(axis=1)
    return Defect(
        objects,
        f"{objects[1]} and {objects[2]} run together on {objects[0]} along {plural(len(edges), 'edge')}.",
        "Let the two faults cross at an angle, or end one at the other.",
        count=len(edges),
        value=float(lengths.sum()),
        unit=unit,
        place=places[np.argmax(lengths)],
        elements=ints(np.unique(edges)),
        places=floats(places, -1, 3),
        blocks=True,
    )


CHECK = Check(
    "junction",
    "3.2, condition 4",
    "Two faults meet on a horizon in points only.",
    need=Need.GRAPH,
    repairable=True,
    run=_run,
)
