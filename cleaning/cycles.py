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
from graben.finding import Finding
from graben.validators.acyclic import Cycle, cycles
from graben.validators.context import Need
from graben.validators.measuring.measures import amount
from graben.words import plural

#: Cycles of a horizon that a note tells one by one.
MOST_TOLD = 3


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
    """Return, for each horizon concerned, the shortest cuts that would open its cycles."""
    made: list[Change | Refusal] = []
    for finding in task.findings:
        graph = task.evidence.graphs.get(finding.objects[0])
        if graph is not None:
            made.append(_said(task, finding, graph))
    return made


def _said(task: Task, finding: Finding, graph: CutGraph) -> Refusal:
    """Return what it would take to open the cycles of a horizon, and where the shortest cut would be."""
    around = cycles(graph)
    cheapest = [next(iter(openings(graph, cycle)), None) for cycle in around]
    reasons = [_reason(task, cycle, best) for cycle, best in zip(around, cheapest, strict=True)]
    more = len(reasons) - MOST_TOLD
    told = " ".join(reasons[:MOST_TOLD]) + (f" And {plural(more, 'cycle')} more." if more > 0 else "")
    best = min((o for o in cheapest if o is not None), key=lambda o: o.length, default=None)
    if best is None:
        return Refusal(finding.check, finding.objects, told, finding.remedy)
    return Refusal(finding.check, finding.objects, told, finding.remedy, best.place)


def _reason(task: Task, cycle: Cycle, best: Opening | None) -> str:
    """Return a sentence: which faults close a cycle, and where the shortest cut would open it."""
    names = [f.name for f in task.model.faults]
    closed = ", ".join(dict.fromkeys(names[k] for k in cycle.faults))
    if best is None:
        return f"The cycle of {closed} has no corner beyond which a fault could be cut off."
    fault = names[best.fault]
    gap = f"wider than max_extension = {amount(task.max_extension(fault), task.unit)}, or it is closed again"
    if best.length <= task.contact:
        return f"The cycle of {closed} costs least to open where {fault} ends at it: by a gap {gap}."
    beyond = amount(best.length, task.unit)
    return (
        f"The cycle of {closed} costs least to open at {fault}: {beyond} of its trace lie beyond that "
        f"corner, and a gap has to follow that is {gap}."
    )


REPAIR = Repair(
    "cycles",
    ("acyclic",),
    "Says where a cycle that nothing holds could be opened with the shortest cut.",
    _propose,
    need=Need.ANCHORS,
)
