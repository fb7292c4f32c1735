"""contacts: faults that meet share edges; gaps are closed, stubs cut back, rims put exactly on other faults.

Answers `simplicial-complex`, `near-miss` and `junction-values`. Faults that meet are worked on together, as
one complex: what is done to a vertex or an edge that several of them have is done to all of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from graben.arrays import BoolArray, FloatArray, IntArray, floats
from graben.cleaning.meetings import Decision, What, chain_of, decided, in_turn, linked
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task
from graben.cleaning.shaping.complex_mesh import Net, Tables, taken
from graben.cleaning.shaping.complex_passes import Goal
from graben.cleaning.shaping.conforming import (
    bettered,
    conformed,
    divided,
    stacked,
    surfaces_of,
    torn,
    welded,
)
from graben.cleaning.shaping.extension import extended
from graben.cleaning.shaping.imprint import imprinted
from graben.cleaning.shaping.limits import ROUNDING, joined
from graben.cleaning.shaping.rim_chains import ways_on
from graben.errors import GrabenError
from graben.finding import Finding, Status
from graben.model import Model
from graben.proximity import nearest
from graben.surface import Surface, triangle_areas
from graben.validators.context import Need
from graben.validators.measuring.hits import TriangleTree
from graben.validators.measuring.measures import amount, components
from graben.validators.measuring.rim_lines import unit

#: Least angle that triangles along branch lines are brought to where their surroundings allow it, degrees.
ANGLE = 10.0
#: How far a line may be led off the surfaces: share of max_move, and of the median edge.
OFF, OFF_EDGE = 0.25, 0.05
#: Share of the contact distance within which vertices of the exact refinement are one.
NOISE = 0.1
#: A way beyond a rim is looked along for so many times the gap.
_FURTHER = 1.5
#: Share of a fault's area that is cut back as a stub; more is a matter for a person.
MOST_CUT = 0.1
#: Share of the median edge below which a rim's vertex is there already.
_REACHED = 0.05
#: Least cosine between the way on and that to the nearest point of the other for it to lie ahead: 30 degrees.
_AHEAD = 0.866
#: Share of max_move that a rim is moved by at most: other repairs may have moved it before.
_MOVED = 0.5
#: Share of a gap by which the rim of an extension may miss the other fault and is then moved onto it.
_LANDING = 0.25


def _answers(finding: Finding, model: Model) -> bool:
    """Return whether a finding asks for it: one that fails, and gaps and stubs, which only warn."""
    warns = finding.check == "near-miss" and finding.status is Status.WARN and model.repair.warnings
    return finding.status is Status.FAIL or warns


def _propose(task: Task) -> list[Change | Refusal]:
    decisions, refusals = decided(task)
    proposed: list[Change | Refusal] = list(refusals)
    for group in linked(task, decisions):
        inside = [d for d in decisions if d.own in group and set(d.others) <= set(group)]
        proposed += _worked(task, group, inside)
    return proposed


def _worked(task: Task, group: Sequence[int], decisions: Sequence[Decision]) -> list[Change | Refusal]:
    """Return the change of a group of faults that meet, and what of it is left."""
    old = [task.model.faults[k].surface for k in group]
    place = {k: n for n, k in enumerate(group)}
    grown, patches, fronts, steps, refusals = _extended(task, group, decisions)
    decisions = [_with_neighbours(task, group, d, fronts.get(d.own)) for d in decisions]
    net = stacked(grown, _meeting(task, group, decisions))
    for decision in in_turn(decisions):
        own, landing = place[decision.own], decision.what is What.EXTEND
        front = fronts.get(decision.own)
        if decision.what is What.CUT or (landing and front is None):
            continue
        reach = _LANDING * decision.size if landing else decision.size
        reach = min(reach, _MOVED * task.max_move(old[own].name))
        for other in (place[k] for k in decision.others):
            try:
                net = imprinted(net, own, other, reach, task.contact, front if landing else None)
            except GrabenError:
                refusals.append(_tangled(decision, old[own].name, old[other].name))
    goal = Goal(ANGLE, min(_off(task, surface) for surface in old))
    net = welded(divided(bettered(net, goal))[0], NOISE * task.contact)
    crossed = [group[n] for n in torn(net).tolist()]
    if crossed:
        rest = [k for k in group if k not in crossed]
        within = [d for d in decisions if d.own in rest and set(d.others) <= set(rest)]
        return [r for k in crossed for r in _waits(task, k)] + (
            _worked(task, rest, within) if len(rest) > 1 else []
        )
    # slivers at the ends of a branch line can hold together what it cuts: they go first
    net = bettered(net, goal)
    for decision in (d for d in decisions if d.what is What.CUT):
        net, done = _cut_back(task, net, decision, place)
        steps += [s for s in done if isinstance(s, Step)]
        refusals += [r for r in done if isinstance(r, Refusal)]
    net = bettered(net, goal)
    made = surfaces_of(conformed(net, goal, NOISE * task.contact), old)
    changed: dict[str, tuple[Surface, ...]] = {
        a.name: (b,) for a, b in zip(old, made, strict=True) if b is not a
    }
    if not changed:
        return list(refusals)
    steps += _shared_lines(task, changed, decisions)
    if not steps:
        return list(refusals)
    declared = {name: patch for name, patch in patches.items() if name in changed}
    return [Change(changed, tuple(steps), declared), *refusals]


def _waits(task: Task, fault: int) -> list[Refusal]:
    """Return why a fault that is no manifold surface once refined is left alone, finding by finding."""
    name = task.model.faults[fault].name
    return [
        Refusal(
            finding.check,
            finding.objects,
            f"{name} crosses itself or has edges with three triangles or more: no line can be put into it.",
            "Repair that first, by hand if need be.",
        )
        for finding in task.findings
        if name in finding.objects
    ]


def _tangled(decision: Decision, own: str, other: str) -> Refusal:
    return Refusal(
        decision.check,
        (own, other),
        f"The rim of {own} runs to and fro on {other}, so that no line in which they meet can be drawn.",
        "Straighten the rim there, or end one of the two before the other.",
        decision.place,
    )


def _with_neighbours(
    task: Task, group: Sequence[int], decision: Decision, front: FloatArray | None
) -> Decision:
    """Return a decision to extend a fault with all others that it comes to meet there.

    Where others meet in a line, and the new rim lands on that, it meets all of them.
    """
    if decision.what is not What.EXTEND or front is None:
        return decision
    beside = set(decision.others)
    for contact in task.evidence.contacts:
        if beside.intersection(contact.surfaces):
            beside |= set(contact.surfaces)
    reach = _LANDING * decision.size
    more = []
    for k in sorted(beside.intersection(group) - {decision.own, *decision.others}):
        surface = task.model.faults[k].surface
        if (nearest(front, surface.vertices, surface.triangles).distance <= reach).any():
            more.append(k)
    return replace(decision, others=(*decision.others, *more))


def _meeting(task: Task, group: Sequence[int], decisions: Iterable[Decision]) -> BoolArray:
    """Return which faults of a group meet, or are to, shape (faults, faults)."""
    meeting = np.eye(len(task.model.faults), dtype=np.bool_)
    pairs = [c.surfaces for c in task.evidence.contacts] + [
        (d.own, other) for d in decisions for other in d.others
    ]
    a, b = np.array(pairs).T
    meeting[a, b] = meeting[b, a] = True
    return np.asarray(meeting[np.ix_(group, group)], dtype=np.bool_)


def _off(task: Task, surface: Surface) -> float:
    return min(OFF * task.max_move(surface.name), OFF_EDGE * surface.median_edge)


def _extended(
    task: Task, group: Sequence[int], decisions: Iterable[Decision]
) -> tuple[list[Surface], dict[str, Surface], dict[int, FloatArray], list[Step], list[Refusal]]:
    """Return the faults of a group extended over their gaps, the patches, the new rims, and the steps."""
    grown = {k: task.model.faults[k].surface for k in group}
    patches: dict[str, Surface] = {}
    fronts: dict[int, FloatArray] = {}
    steps: list[Step] = []
    refusals: list[Refusal] = []
    for decision in (d for d in decisions if d.what is What.EXTEND):
        k = decision.own
        own, others = grown[k], [task.model.faults[j].surface for j in decision.others]
        names = " and ".join(s.name for s in others)
        chain = chain_of(own, decision.path)
        # first on along the fault's own trend, whatever notches its rim has, then square to the rim itself
        for straight in (True, False):
            far = _lengths(own, chain, others, decision.size, straight)
            made = None if far is None else extended(own, chain, far, straight=straight)
            if made is not None and not made.folded:
                break
        limit = task.max_extension(own.name)
        if made is None or made.folded or made.length > limit * (1.0 + ROUNDING):
            why = f"it would not meet {names}" if made is None else "it would fold over"
            needed = None
            if made is not None and not made.folded:
                why = f"that takes {amount(made.length, task.unit)}, more than max_extension = {limit:.3g}"
                needed = made.length - limit
            refusals.append(_not_extended(task, decision, names, why, needed))
            continue
        grown[k] = made.surface
        front = made.surface.vertices[made.front]
        fronts[k] = floats(np.concatenate([fronts[k], front])) if k in fronts else floats(front)
        patches[own.name] = joined(patches[own.name], made.patch) if own.name in patches else made.patch
        along = float(np.linalg.norm(np.diff(decision.path, axis=0), axis=1).sum())
        steps.append(
            Step(
                "near-miss",
                (own.name,),
                len(made.triangles),
                decision.place,
                f"{own.name} was extended along its trend by up to {amount(made.length, task.unit)}, to "
                f"{names}, along {amount(along, task.unit)} of its rim.",
                made.length,
                task.unit,
            )
        )
    return [grown[k] for k in group], patches, fronts, steps, refusals


def _not_extended(task: Task, decision: Decision, names: str, why: str, needed: float | None) -> Refusal:
    own = task.model.faults[decision.own].name
    return Refusal(
        "near-miss",
        (own, task.model.faults[decision.others[0]].name),
        f"{own} ends {amount(decision.size, task.unit)} short of {names}; extended along its trend {why}.",
        "Extend it by hand, or say that it is meant so under [[contacts]].",
        decision.place,
        needed,
        task.unit,
    )


def _lengths(
    own: Surface, chain: IntArray, others: Sequence[Surface], size: float, straight: bool
) -> FloatArray | None:
    """Return how far it is from each vertex of a chain of the rim to other faults, along the way on.

    Where the way misses them, what its neighbours have; None where all miss.
    """
    if len(chain) < 2:
        return None
    ways = ways_on(own, chain, floats(np.ones(len(chain))), 2.0 * own.median_edge, straight)
    reach = _FURTHER * size
    points = own.vertices[chain]
    far = reach * TriangleTree(others).first(points, reach * ways.way, -1).distance
    # a way that just misses the rim of the other goes as far as to its nearest point, where that lies ahead
    all_others = others[0]
    for other in others[1:]:
        all_others = joined(all_others, other)
    near = nearest(points, all_others.vertices, all_others.triangles)
    ahead = np.einsum("ij,ij->i", near.place - points, unit(ways.way)) >= _AHEAD * near.distance
    far = np.where(np.isinf(far) & ahead & (near.distance <= reach), near.distance, far)
    met = np.isfinite(far)
    if not met.any():
        return None
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    far = np.interp(s, s[met], far[met])
    # where the rim all but reaches the others it is moved there, and nothing is added
    return floats(np.where(far < _REACHED * own.median_edge, 0.0, far))


def _cut_back(
    task: Task, net: Net, decision: Decision, place: dict[int, int]
) -> tuple[Net, list[Step | Refusal]]:
    """Return a net without the parts of a fault that another cuts off and that are stubs."""
    own, other = place[decision.own], place[decision.others[0]]
    names = tuple(task.model.faults[k].name for k in (decision.own, decision.others[0]))
    tables = Tables(net, task.contact)
    mine = np.flatnonzero(net.owner == own)
    common = np.intersect1d(tables.sides[mine], tables.sides[net.owner == other])
    where = decision.place
    left = Refusal(
        "near-miss",
        (names[0], names[1]),
        f"{names[0]} ends {amount(decision.size, task.unit)} beyond {names[1]}, which does not cut "
        "all of that off.",
        "Cut it back by hand, or say that it is meant so under [[contacts]].",
        where,
    )
    if not len(common):
        return net, [left]
    part = _parts(tables, mine, common)
    areas = np.bincount(part, triangle_areas(net.vertices, net.triangles[mine]))
    corners = net.vertices[net.triangles[mine]].reshape(-1, 3)
    away = nearest(corners, net.vertices, tables.edges[common]).distance.reshape(-1, 3).max(axis=1)
    reach = np.zeros(len(areas))
    np.maximum.at(reach, part, away)
    limit = task.max_extension(names[0])
    gone = (reach > task.contact) & (reach <= limit) & (areas <= MOST_CUT * areas.sum())
    gone[areas.argmax()] = False
    if not gone.any():
        return net, [left]
    stays = np.ones(len(net.triangles), dtype=bool)
    stays[mine[gone[part]]] = False
    size = float(reach[gone].max())
    step = Step(
        "near-miss",
        (names[0],),
        int((~stays).sum()),
        where,
        f"{names[0]} was cut back by up to {amount(size, task.unit)}, to {names[1]}.",
        size,
        task.unit,
    )
    return taken(net, stays), [step]


def _parts(tables: Tables, mine: IntArray, common: IntArray) -> IntArray:
    """Return the part of each triangle of a surface that is cut along some edges, shape (k,)."""
    sides = tables.sides[mine]
    joined_by = ~np.isin(sides, common)
    row = np.repeat(np.arange(len(mine)), 3).reshape(-1, 3)[joined_by]
    edges, local = np.unique(sides[joined_by], return_inverse=True)
    pairs = np.stack([row, len(mine) + local.reshape(-1)], axis=1)
    return np.unique(components(len(mine) + len(edges), pairs)[: len(mine)], return_inverse=True)[1].reshape(
        -1
    )


def _shared_lines(
    task: Task, changed: dict[str, tuple[Surface, ...]], decisions: Iterable[Decision]
) -> list[Step]:
    """Return a step for each pair of faults that got common edges, for the gravest of its findings."""
    faults = task.model.faults
    joining = {
        frozenset(faults[k].name for k in (d.own, d.others[0])): d for d in decisions if d.what is What.JOIN
    }
    known = {f.name for f in faults}
    steps: dict[frozenset[str], Step] = {}
    for finding in task.findings:
        names = tuple(n for n in finding.objects if n in known)
        pair = frozenset(names)
        told = pair in steps or (finding.check == "near-miss" and pair not in joining)
        if len(names) != 2 or told or not pair.intersection(changed):
            continue
        reason = f"{names[0]} and {names[1]} have the line in which they meet as common edges now"
        if pair in joining:
            reason += f"; the rim of {faults[joining[pair].own].name} was put on the other"
        place = finding.places[0] if len(finding.places) else None
        steps[pair] = Step(finding.check, names, finding.count, place, f"{reason}.")
    return list(steps.values())


REPAIR = Repair(
    "contacts",
    ("simplicial-complex", "near-miss", "junction-values"),
    "gives faults that meet common edges, extends them over gaps, cuts stubs back, puts rims on other faults",
    _propose,
    Need.ANCHORS,
    _answers,
)
