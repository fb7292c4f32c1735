"""trace-ends: a trace that ends nowhere goes on to where it may end, its fault extended (answers `trace`)."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from graben.arrays import floats, ints
from graben.cleaning.margin import grown
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task
from graben.cleaning.shaping.rim_lengths import resting, rim_needs
from graben.cutgraph import CutGraph
from graben.errors import GrabenError
from graben.finding import Finding, Status
from graben.model import Fault, Horizon, Model
from graben.proximity import nearest
from graben.surface import boundary_edges
from graben.validators.context import Need
from graben.validators.measuring.measures import amount
from graben.validators.measuring.trace_measures import Goal, LooseEnd, loose_ends, outline

#: A part of this kind says of an end that it lies nowhere.
_LOOSE = "loose end"
#: An end within so many steps of the rim of its fault is where the fault ends.
_AT_RIM = 1.0
#: Beyond the place where the trace may end the fault goes on by so many steps, so that it is sure to pass it.
_BEYOND = 0.5


def _propose(task: Task) -> Sequence[Change | Refusal]:
    """Return the extension of each fault with loose ends, and the ends that no extension helps."""
    made: list[Change | Refusal] = []
    for fault in task.model.faults:
        if frozenset([fault.name]) in task.vetoed:
            continue
        short: list[tuple[Horizon, CutGraph, LooseEnd]] = []
        for horizon in task.model.horizons:
            graph = task.evidence.graphs.get(horizon.name)
            objects = (horizon.name, fault.name)
            if graph is None or not any(f.objects[:2] == objects for f in task.findings):
                continue
            surfaces = [f.surface for f in task.model.faults]
            for end in loose_ends(horizon, graph, task.index(fault.name), surfaces, outline(horizon.surface)):
                refusal = _refused(task, fault, horizon, graph, end)
                if refusal is None:
                    short.append((horizon, graph, end))
                else:
                    made.append(refusal)
        if short:
            made.append(_extension(task, fault, short))
    return made


def _refused(task: Task, fault: Fault, horizon: Horizon, graph: CutGraph, end: LooseEnd) -> Refusal | None:
    """Return why an end is no matter of the fault's length, or out of reach; None where it is in reach."""
    place, unit = graph.nodes[end.node], task.unit
    objects = (horizon.name, fault.name)
    title = f"The trace of {fault.name} on {horizon.name} ends"
    goal = f"{amount(end.distance, unit)} short of {end.goal.value}{end.name}"
    if end.at_hole:
        reason = f"{title} at a hole of {horizon.name}, {goal}: the fault cannot mend that."
        return Refusal("trace", objects, reason, f"Close the hole of {horizon.name} there.", floats(place))
    rim = boundary_edges(fault.surface.triangles)
    away = float(nearest(place[None], fault.surface.vertices, rim).distance[0]) if len(rim) else np.inf
    if end.goal is Goal.RIM or away > _AT_RIM * horizon.step:
        reason = f"{title} where the fault goes on, {goal}."
        return Refusal(
            "trace", objects, reason, "Look at the fault and the horizon at that place.", floats(place)
        )
    limit = task.max_extension(fault.name)
    needed = end.distance + _BEYOND * horizon.step
    if needed <= limit:
        return None
    reason = f"{title} {goal}, which takes {amount(needed, unit)}, more than max_extension = "
    return Refusal(
        "trace",
        objects,
        f"{reason}{amount(limit, unit)}.",
        "Raise max_extension, or extend the fault in its interpretation.",
        floats(place),
        needed - limit,
        unit,
    )


def _extension(
    task: Task, fault: Fault, short: Sequence[tuple[Horizon, CutGraph, LooseEnd]]
) -> Change | Refusal:
    """Return a fault extended as far as the ends of its traces need it."""
    surface, unit = fault.surface, task.unit
    horizon, graph, end = max(short, key=lambda s: s[2].distance)
    place, objects = floats(graph.nodes[end.node]), (horizon.name, fault.name)
    ends = floats([g.nodes[e.node] for _, g, e in short])
    places = nearest(ends, surface.vertices, ints(boundary_edges(surface.triangles))).place
    needs = floats([e.distance + _BEYOND * h.step for h, _, e in short])
    held = resting(surface, [f.surface for f in task.model.faults if f.name != fault.name], task.contact)
    try:
        whole, patch, folded = grown(surface, rim_needs(surface, places, needs, held))
    except GrabenError as error:
        return Refusal("trace", objects, f"{error}", "Repair the rim of the fault first.", place)
    if folded or not len(patch.triangles):
        reason = f"{fault.name} cannot go on {amount(float(needs.max()), unit)} there: it would fold over."
        return Refusal("trace", objects, reason, "Extend the fault by hand.", place)
    step = Step(
        "trace",
        objects,
        len(short),
        place,
        f"{fault.name} was extended by up to {amount(float(needs.max()), unit)}, so that its trace on "
        f"{horizon.name} reaches {end.goal.value}{end.name}.",
        float(needs.max()),
        unit,
    )
    return Change({fault.name: (whole,)}, (step,), MappingProxyType({fault.name: patch}))


def _loose(finding: Finding, model: Model) -> bool:
    """Return whether a finding fails for ends that lie nowhere."""
    return finding.status is Status.FAIL and any(part.kind == _LOOSE for part in finding.parts)


REPAIR = Repair(
    "trace-ends",
    ("trace",),
    "Extends a fault whose trace ends nowhere to where it may end.",
    _propose,
    need=Need.GRAPH,
    answers=_loose,
)
