"""margin: a fault that ends before a horizon's cutoff is extended up or down dip (answers `trace`)."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType

import numpy as np

from graben.arrays import FloatArray, IntArray, floats
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task
from graben.cleaning.shaping.extension import extended
from graben.cleaning.shaping.rim_lengths import resting, rim_needs
from graben.errors import GrabenError
from graben.finding import Finding, Status
from graben.model import Fault, Model
from graben.surface import Surface, triangle_areas, triangle_dips
from graben.validators.context import Need
from graben.validators.measuring.measures import amount
from graben.validators.measuring.reach import reach_of
from graben.validators.trace import TOO_SHORT

#: What is added to what is missing: a share of it, since planes foretell the cutoff, and so many median edges
#: of the fault or steps of the horizons, whichever is less: a much thinner strip would be made of slivers.
_SHARE, _EDGES = 0.2, 0.3


def _propose(task: Task) -> Sequence[Change | Refusal]:
    """Return the extension of each fault that ends too early on some horizon."""
    names = {f.objects[1] for f in task.findings}
    made: list[Change | Refusal] = []
    for fault in task.model.faults:
        if fault.name in names and frozenset([fault.name]) not in task.vetoed:
            made += _for_fault(task, fault)
    return made


def _for_fault(task: Task, fault: Fault) -> list[Change | Refusal]:
    """Return the extension of one fault, or why there is none."""
    places, needs, horizons = _missing(task, fault)
    if not len(needs):
        return []
    surface, limit = fault.surface, task.max_extension(fault.name)
    worst, unit = int(np.argmax(needs)), task.unit
    objects = (horizons[0], fault.name)
    greatest = float(needs[worst])
    if greatest > limit:
        return [
            Refusal(
                "trace",
                objects,
                f"{fault.name} ends {amount(greatest, unit)} too early for {horizons[worst]}, more than "
                f"max_extension = {amount(limit, unit)}.",
                "Raise max_extension, extend the fault in its interpretation, or lower gamma.",
                floats(places[worst]),
                greatest - limit,
                unit,
            )
        ]
    more = _EDGES * min(surface.median_edge, *(h.step for h in task.model.horizons))
    wanted = np.minimum(needs * (1.0 + _SHARE) + more, limit)
    others = [f.surface for f in task.model.faults if f.name != fault.name]
    held = resting(surface, others, task.contact)
    gamma = max(task.model.gamma(fault, h) for h in task.model.horizons)
    try:
        whole, patch, folded = grown(surface, rim_needs(surface, places, floats(wanted), held, gamma))
    except GrabenError as error:
        return [Refusal("trace", objects, f"{error}", "Repair the rim of the fault first.")]
    if folded or not len(patch.triangles):
        reason = f"{fault.name} cannot go on {amount(greatest, unit)} from its rim: it would fold over."
        return [Refusal("trace", objects, reason, "Extend the fault by hand.", floats(places[worst]))]
    step = Step(
        "trace",
        objects,
        len(patch.triangles),
        floats(places[worst]),
        f"{fault.name} was extended along its trend by up to {amount(float(wanted.max()), unit)}, since the "
        f"cutoffs of {', '.join(dict.fromkeys(horizons))} lie up to {amount(greatest, unit)} beyond its rim; "
        f"{_effects(surface, whole)}.",
        float(wanted.max()),
        unit,
    )
    return [Change({fault.name: (whole,)}, (step,), MappingProxyType({fault.name: patch}))]


def _effects(before: Surface, after: Surface) -> str:
    """Return what an extension makes of a fault beside being longer: its area, and its least dip if less."""
    areas = [float(triangle_areas(s.vertices, s.triangles).sum()) for s in (before, after)]
    said = f"its area grew by {100.0 * (areas[1] / areas[0] - 1.0):.2g} %"
    least = [float(triangle_dips(s.vertices, s.triangles).min()) for s in (before, after)]
    if f"{least[1]:.1f}" == f"{least[0]:.1f}" or least[1] > least[0]:
        return f"{said}, its least dip stayed"
    return f"{said}, its least dip fell from {least[0]:.1f} to {least[1]:.1f} degrees"


def _missing(task: Task, fault: Fault) -> tuple[FloatArray, FloatArray, list[str]]:
    """Return where on its rim a fault ends too early, by how much along its dip, and for which horizon."""
    faults = [f.surface for f in task.model.faults]
    number = task.index(fault.name)
    short = {f.objects[0] for f in task.findings if f.objects[1] == fault.name}
    places, needs, horizons = [np.zeros((0, 3))], [np.zeros(0)], []
    for horizon in task.model.horizons:
        graph = task.evidence.graphs.get(horizon.name)
        if horizon.name not in short or graph is None or not (graph.faults == number).any():
            continue
        gammas = {
            k: task.model.gamma(task.model.faults[k], horizon) for k in np.unique(graph.faults).tolist()
        }
        reach = reach_of(horizon, faults, graph, number, gammas, task.contact)
        for missing, rim in ((reach.missing_above, reach.above), (reach.missing_below, reach.below)):
            some = (missing > 0) & (reach.dip[:, 2] < 0)
            places.append(rim[some])
            needs.append(missing[some] / -reach.dip[some, 2])
            horizons += [horizon.name] * int(some.sum())
    return floats(np.concatenate(places)), floats(np.concatenate(needs)), horizons


def grown(surface: Surface, chains: Sequence[tuple[IntArray, FloatArray]]) -> tuple[Surface, Surface, int]:
    """Return a fault extended from several chains of its rim, what was added, and how much of it folds."""
    whole, folded = surface, 0
    vertices, triangles = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.int64)]
    for chain, length in chains:
        made = extended(whole, chain, length)
        whole, folded = made.surface, folded + made.folded
        triangles.append(made.patch.triangles + sum(len(v) for v in vertices))
        vertices.append(made.patch.vertices)
    patch = Surface(surface.name, floats(np.concatenate(vertices)), np.concatenate(triangles))
    return whole, patch, folded


def _short(finding: Finding, model: Model) -> bool:
    """Return whether a finding says that a fault is too short, and fails, or warnings are repaired."""
    asks = finding.status is Status.FAIL or model.repair.warnings
    return asks and any(part.kind == TOO_SHORT for part in finding.parts)


REPAIR = Repair(
    "margin",
    ("trace",),
    "Extends a fault up or down dip where a horizon's cutoff would lie beyond its rim.",
    _propose,
    need=Need.GRAPH,
    answers=_short,
)
