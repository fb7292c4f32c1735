"""What is to be done where faults meet, decided from what the stretches of their rims do."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from graben.arrays import IntArray
from graben.cleaning.repairing import Refusal, Task
from graben.cleaning.rim_chains import at_corners, stretch_chain
from graben.surface import Surface
from graben.validators.measuring.contact import ContactKind
from graben.validators.measuring.measures import amount, components
from graben.validators.measuring.rim_labels import RimLabel
from graben.validators.measuring.rims import Stretch, rim_stretches

#: A rim that strays from another fault by no more than this share of the fault's median edge, and half of
#: max_move, lies on it: its vertices are moved there. What strays further is extended or cut back.
STRAY = 0.1
#: How much further than the middles of a rim's pieces its vertices may lie off the other fault.
_BEYOND = 1.5
#: Distance over the contact distance within which rims that lie on each other are made one.
_ON = 2.0
#: Share of the median edge within which a rim's vertex lies on a stretch of it.
_ALONG = 0.01


class What(StrEnum):
    """What is done with a rim at another fault."""

    JOIN = "join"  #: its vertices are moved onto the other by a little, and become the other's
    EXTEND = "extend"  #: the fault is extended to the other
    CUT = "cut back"  #: what lies beyond the other is taken away


@dataclass(frozen=True, eq=False)
class Decision:
    """What is to be done with the rim of one fault at another.

    Parameters
    ----------
    what : What
        It.
    own, other : int
        The fault and the other, by their position in the model.
    check : str
        The check that is answered.
    size : float
        How far the rim lies off the other at most, model units.
    stretches : tuple of Stretch
        Where; empty for all of the rim.
    """

    what: What
    own: int
    other: int
    check: str
    size: float
    stretches: tuple[Stretch, ...] = ()


def decided(task: Task) -> tuple[list[Decision], list[Refusal]]:
    """Return what to do at each pair of faults with a finding, and what is left to a person."""
    faults = [f.surface for f in task.model.faults]
    number = {s.name: k for k, s in enumerate(faults)}
    limits = [task.model.checks.get("near-miss", task.max_extension(s.name)) for s in faults]
    assert task.evidence.complex is not None
    stretches = rim_stretches(faults, task.evidence.complex, limits, task.contact)
    asking = _asking(task)
    by_pair: dict[tuple[str, str], list[Stretch]] = {}
    for stretch in stretches:
        pair = (stretch.fault, stretch.neighbour)
        if frozenset(pair) in asking and frozenset(pair) not in task.vetoed:
            by_pair.setdefault(pair, []).append(stretch)
    decisions: list[Decision] = []
    refusals: list[Refusal] = []
    for pair, own in by_pair.items():
        made, left = _of_pair(task, (number[pair[0]], number[pair[1]]), own, asking[frozenset(pair)])
        decisions += made
        refusals += left
    return decisions, refusals


def _asking(task: Task) -> dict[frozenset[str], set[str]]:
    """Return the pairs of faults with a finding, each with the checks that made one."""
    faults = {f.name for f in task.model.faults}
    asking: dict[frozenset[str], set[str]] = {}
    for finding in task.findings:
        pair = frozenset(faults.intersection(finding.objects))
        if len(pair) == 2:
            asking.setdefault(pair, set()).add(finding.check)
    return asking


def _of_pair(
    task: Task, pair: tuple[int, int], stretches: Sequence[Stretch], checks: set[str]
) -> tuple[list[Decision], list[Refusal]]:
    """Return what to do with the stretches of one fault's rim at another."""
    surface = task.model.faults[pair[0]].surface
    rule = task.rule(stretches[0].fault, stretches[0].neighbour)
    if rule == "forbid":
        return [], []
    stray = min(0.5 * task.max_move(surface.name), STRAY * surface.median_edge)
    check = "near-miss" if "near-miss" in checks else min(checks)
    near = [s for s in stretches if s.label is RimLabel.ON or _off(s) <= stray]
    if "simplicial-complex" not in checks and not any(s.label is RimLabel.ON for s in near):
        near = [s for s in near if s.label is RimLabel.STUB or _whole_side(task, s, ())]
    far = [s for s in stretches if s.label in (RimLabel.GAP, RimLabel.STUB) and not any(s is n for n in near)]
    decisions: list[Decision] = []
    refusals: list[Refusal] = []
    if near:
        size = max(_ON * task.contact, _BEYOND * max(map(_off, near)))
        decisions.append(Decision(What.JOIN, *pair, check, size))
    if rule == "accept" or "near-miss" not in checks:
        return decisions, refusals
    gaps = [s for s in far if s.label is RimLabel.GAP]
    clear = [s for s in gaps if rule == "force" or _whole_side(task, s, near)]
    if clear:
        decisions.append(Decision(What.EXTEND, *pair, check, max(map(_off, clear)), tuple(clear)))
    refusals += [_unclear(task, s) for s in gaps if not any(s is c for c in clear)]
    stubs = [s for s in far if s.label is RimLabel.STUB]
    if stubs:
        decisions.append(Decision(What.CUT, *pair, check, max(map(_off, stubs)), tuple(stubs)))
    return decisions, refusals


def _off(stretch: Stretch) -> float:
    """Return how far a stretch lies off the other fault at most, model units."""
    return stretch.greatest if stretch.label in (RimLabel.GAP, RimLabel.STUB) else 0.0


def chain_of(task: Task, stretch: Stretch) -> IntArray:
    """Return the rim vertices along a stretch, shape (k,); empty where it covers no edge."""
    surface = task.fault(stretch.fault).surface
    return stretch_chain(surface, stretch.path, _ALONG * surface.median_edge)


def _whole_side(task: Task, stretch: Stretch, near: Sequence[Stretch]) -> bool:
    """Return whether a stretch goes from corner to corner of its fault, or to where that meets the other."""
    chain = chain_of(task, stretch)
    if len(chain) < 2:
        return False
    surface = task.fault(stretch.fault).surface
    ends = at_corners(surface, chain)
    if not near:
        return bool(ends.all())
    meeting = np.concatenate([s.path[[0, -1]] for s in near])
    own = stretch.path[[0, -1]] if _along(surface, chain, stretch) else stretch.path[[-1, 0]]
    beside = np.linalg.norm(own[:, None] - meeting, axis=2).min(axis=1) <= task.contact
    return bool((ends | beside).all())


def _along(surface: Surface, chain: IntArray, stretch: Stretch) -> bool:
    """Return whether a chain of rim vertices begins where its stretch does."""
    away = np.linalg.norm(surface.vertices[chain[[0, -1]]] - stretch.path[0], axis=1)
    return bool(away[0] <= away[1])


def _unclear(task: Task, stretch: Stretch) -> Refusal:
    gap = amount(stretch.least, task.unit)
    return Refusal(
        "near-miss",
        (stretch.fault, stretch.neighbour),
        f"{stretch.fault} ends {gap} short of {stretch.neighbour} with a part of a side only, so that it is "
        "not clear that they are meant to meet.",
        'If they are, say rule = "force" for the two under [[contacts]]; if not, rule = "accept".',
        stretch.place,
        stretch.greatest,
        task.unit,
    )


def linked(task: Task, decisions: Iterable[Decision]) -> list[list[int]]:
    """Return the groups of faults that must be worked on together, by position.

    They are linked by a finding, by what is to be done, and by edges that they share already.
    """
    names = {f.name: k for k, f in enumerate(task.model.faults)}
    pairs = [(d.own, d.other) for d in decisions]
    asked = {k for pair in pairs for k in pair}
    for finding in task.findings:
        members = [names[n] for n in finding.objects if n in names]
        vetoed = frozenset(task.model.faults[k].name for k in members) in task.vetoed
        if len(members) == 2 and finding.check == "simplicial-complex" and not vetoed:
            pairs.append((members[0], members[1]))
            asked.update(members)
    if not pairs:
        return []
    shared = [c.surfaces for c in task.evidence.contacts if c.kind is ContactKind.EDGE]
    label = components(len(names), np.array([*pairs, *shared]))
    groups = [np.flatnonzero(label == k).tolist() for k in np.unique(label[sorted(asked)])]
    return [g for g in groups if len(g) > 1]
