"""cycles: says which fault would have to be cut back, and how far, to open a cycle (answers `acyclic`).

No fault is cut here: a gap as narrow as one that a contact may close would be closed again, and a wider one
is a decision about the fault's extent, which no measure of the surfaces can take.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graben.arrays import FloatArray, floats
from graben.cleaning.repairing import Change, Refusal, Repair, Task
from graben.cutgraph import CutGraph
from graben.validators.acyclic import Cycle, cycles
from graben.validators.context import Need
from graben.validators.measuring.measures import amount


@dataclass(frozen=True, eq=False)
class Opening:
    """A place where a cycle could be opened: the fault cut back beyond a corner of the cycle.

    Parameters
    ----------
    fault : int
        Index of the fault.
    length : float
        Plan length of its trace from that corner to its end, model units.
    place : (3,) array
        The corner.
    """

    fault: int
    length: float
    place: FloatArray


def openings(graph: CutGraph, cycle: Cycle) -> list[Opening]:
    """Return where a cycle could be opened, the shortest length of a fault to be cut off first.

    At each corner of the cycle a fault goes on outside it as far as its trace goes; what lies beyond the
    corner would be cut off. A fault that other faults meet out there counts with its whole length.
    """
    ring = cycle.nodes.tolist()
    own = set(map(frozenset, zip(ring, [*ring[1:], ring[0]], strict=True)))
    found = []
    for number in sorted(set(cycle.faults)):
        edges = graph.edges[graph.faults == number].tolist()
        inside = [e for e in edges if frozenset(e) in own]
        around: dict[int, list[int]] = {}
        for a, b in edges:
            around.setdefault(a, []).append(b)
            around.setdefault(b, []).append(a)
        degree: dict[int, int] = {}
        for edge in inside:
            for node in edge:
                degree[node] = degree.get(node, 0) + 1
        for corner in sorted(n for n, count in degree.items() if count == 1):
            length = _beyond(graph, around, corner, own)
            found.append(Opening(number, length, floats(graph.nodes[corner])))
    return sorted(found, key=lambda o: o.length)


def _beyond(graph: CutGraph, around: dict[int, list[int]], corner: int, own: set[frozenset[int]]) -> float:
    """Return the plan length of the trace of a fault from a corner of a cycle on, away from the cycle."""
    total, seen, front = 0.0, {corner}, [corner]
    while front:
        node = front.pop()
        for other in around[node]:
            if other not in seen and frozenset((node, other)) not in own:
                seen.add(other)
                front.append(other)
                total += float(np.hypot(*(graph.nodes[other] - graph.nodes[node])[:2]))
    return total


def _propose(task: Task) -> Sequence[Change | Refusal]:
    """Return, for each cycle of the horizons concerned, the shortest cut that would open it."""
    names = [f.name for f in task.model.faults]
    made: list[Change | Refusal] = []
    for finding in task.findings:
        graph = task.evidence.graphs.get(finding.objects[0])
        if graph is not None:
            made += [_said(task, finding.objects[0], graph, cycle, names) for cycle in cycles(graph)]
    return made


def _said(task: Task, horizon: str, graph: CutGraph, cycle: Cycle, names: Sequence[str]) -> Refusal:
    """Return what it would take to open one cycle."""
    unit = task.unit
    closed = ", ".join(dict.fromkeys(names[k] for k in cycle.faults))
    objects = (horizon, *dict.fromkeys(names[k] for k in cycle.faults))
    places = openings(graph, cycle)
    if not places:
        return Refusal(
            "acyclic",
            objects,
            f"The cycle of {closed} on {horizon} has no corner beyond which a fault could be cut off.",
            "Leave a gap in the fault, or reduce gamma there.",
            floats(graph.nodes[cycle.nodes[0]]),
        )
    best = places[0]
    fault, limit = names[best.fault], task.max_extension(names[best.fault])
    than = "within" if best.length <= limit else "more than"
    return Refusal(
        "acyclic",
        objects,
        f"The cycle of {closed} on {horizon} would open with the shortest cut at {fault}: "
        f"{amount(best.length, unit)} of its trace, {than} max_extension = {amount(limit, unit)}.",
        f"Decide whether {fault} ends before that place, and cut it back there; or reduce gamma.",
        best.place,
        best.length,
        unit,
    )


REPAIR = Repair(
    "cycles",
    ("acyclic",),
    "Says where a cycle that nothing holds could be opened with the shortest cut.",
    _propose,
    need=Need.ANCHORS,
)
