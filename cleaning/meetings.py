"""What is to be done where faults meet, decided from what the stretches of their rims do."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np

from graben.arrays import FloatArray, IntArray, floats
from graben.cleaning.repairing import Refusal, Task
from graben.cleaning.shaping.rim_chains import stretch_chain
from graben.cleaning.shaping.runs import Run, runs_of
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
#: A side that is forced to meet another is looked at as far as so many limits.
_FORCED = 2.0
#: Ends of stretches nearer than so many contact distances follow each other.
_JOINED = 10.0
#: Share of the median edge within which a rim's vertex lies on a stretch of it.
_ALONG = 0.01


class What(StrEnum):
    """What is done with a rim at another fault."""

    JOIN = "join"  #: its vertices are moved onto the other by a little, and become the other's
    EXTEND = "extend"  #: the fault is extended to the other
    CUT = "cut back"  #: what lies beyond the other is taken away


@dataclass(frozen=True, eq=False)
class Decision:
    """What is to be done with the rim of one fault at others.

    Parameters
    ----------
    what : What
        It.
    own : int
        The fault, by its position in the model.
    others : tuple of int
        The others; several only where the fault is extended to where several meet.
    check : str
        The check that is answered.
    size : float
        How far the rim lies off the others at most, model units.
    place : (3,) array
        Where that is.
    path : (k, 3) array
        The stretch of the rim; empty for all of it.
    """

    what: What
    own: int
    others: tuple[int, ...]
    check: str
    size: float
    place: FloatArray
    path: FloatArray = field(default_factory=lambda: floats([], 0, 3))


def decided(task: Task) -> tuple[list[Decision], list[Refusal]]:
    """Return what to do at each pair of faults with a finding, and what is left to a person."""
    faults = tuple(f.surface for f in task.model.faults)
    limits = {s.name: task.model.checks.get("near-miss", task.max_extension(s.name)) for s in faults}
    forced = {name for c in task.model.contacts if c.rule == "force" for name in c.faults}
    assert task.evidence.complex is not None
    # a side that is forced to meet another is looked at as a whole, the part beyond the limit with it
    looked = tuple(limits[s.name] * (_FORCED if s.name in forced else 1.0) for s in faults)
    stretches = rim_stretches(task.evidence.complex, faults, looked, task.contact)
    asking = _asking(task)
    by_fault: dict[str, list[Stretch]] = {}
    for stretch in stretches:
        far = _off(stretch) > limits[stretch.fault]
        loose = far and task.rule(stretch.fault, stretch.neighbour) != "force"
        kept = replace(stretch, label=RimLabel.FREE, neighbour="") if loose else stretch
        by_fault.setdefault(stretch.fault, []).append(kept)
    decisions: list[Decision] = []
    refusals: list[Refusal] = []
    for name, own in by_fault.items():
        checks = {
            next(iter(pair - {name})): found
            for pair, found in asking.items()
            if name in pair and pair not in task.vetoed and task.rule(*pair) != "forbid"
        }
        if checks:
            made, left = _of_fault(task, name, own, checks)
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


def _of_fault(
    task: Task, name: str, stretches: Sequence[Stretch], checks: dict[str, set[str]]
) -> tuple[list[Decision], list[Refusal]]:
    """Return what to do with the rim of one fault; ``checks``: what asks for it, by the name of the other."""
    surface = task.fault(name).surface
    stray = min(0.5 * task.max_move(name), STRAY * surface.median_edge)
    decisions: list[Decision] = []
    settled: list[Stretch] = []
    open_: set[str] = set()
    for other, found in checks.items():
        own = [s for s in stretches if s.neighbour == other]
        touching = "simplicial-complex" in found or any(s.label is not RimLabel.GAP for s in own)
        near = [s for s in own if touching and _off(s) <= stray]
        if near:
            worst = max(near, key=_off)
            size = max(_ON * task.contact, _BEYOND * _off(worst))
            decisions.append(_decision(task, What.JOIN, worst, (other,), _check(found), size))
            settled += near
        if task.rule(name, other) == "accept" or "near-miss" not in found:
            continue
        open_.add(other)
        stubs = [s for s in own if s.label is RimLabel.STUB and _off(s) > stray]
        if stubs:
            worst = max(stubs, key=_off)
            decisions.append(_decision(task, What.CUT, worst, (other,), "near-miss", _off(worst)))
    made, refusals = _of_gaps(
        task, surface, runs_of(stretches, open_, _JOINED * task.contact), stray, settled
    )
    return decisions + made, refusals


def _of_gaps(
    task: Task, surface: Surface, runs: Sequence[Run], stray: float, settled: Sequence[Stretch]
) -> tuple[list[Decision], list[Refusal]]:
    """Return what to do where a rim stops short of others, run by run."""
    decisions: list[Decision] = []
    refusals: list[Refusal] = []
    for run in runs:
        gaps = [s for s in run.gaps if not any(s is done for done in settled)]
        if not gaps:
            continue
        forced = any(task.rule(s.fault, s.neighbour) == "force" for s in gaps)
        worst = max(gaps, key=_off)
        if not forced and not run.is_side(surface):
            refusals.append(_unclear(task, worst))
            continue
        others = tuple(dict.fromkeys(s.neighbour for s in (worst, *run.stretches)))
        if _off(worst) <= stray:
            size = _BEYOND * _off(worst)
            decisions += [_decision(task, What.JOIN, worst, (other,), "near-miss", size) for other in others]
        else:
            made = _decision(task, What.EXTEND, worst, others, "near-miss", _off(worst))
            decisions.append(replace(made, path=run.path))
    return decisions, refusals


def _decision(
    task: Task, what: What, stretch: Stretch, others: tuple[str, ...], check: str, size: float
) -> Decision:
    numbers = tuple(task.index(name) for name in others)
    return Decision(what, task.index(stretch.fault), numbers, check, size, stretch.place)


def _check(found: set[str]) -> str:
    return "near-miss" if "near-miss" in found else min(found)


def _off(stretch: Stretch) -> float:
    """Return how far a stretch lies off the other fault at most, model units."""
    return stretch.greatest if stretch.label in (RimLabel.GAP, RimLabel.STUB) else 0.0


def chain_of(surface: Surface, path: FloatArray) -> IntArray:
    """Return the rim vertices of a fault along a path, shape (k,); empty where it covers no edge."""
    return stretch_chain(surface, path, _ALONG * surface.median_edge)


def _unclear(task: Task, stretch: Stretch) -> Refusal:
    gap = amount(stretch.least, task.unit)
    return Refusal(
        "near-miss",
        (stretch.fault, stretch.neighbour),
        f"{stretch.fault} ends {gap} short of {stretch.neighbour} with a part of a side only, so that it is "
        "not clear that they are meant to meet.",
        'If they are, say rule = "force" for the two under [[contacts]]; if not, rule = "accept".',
        stretch.place,
    )


def in_turn(decisions: Iterable[Decision]) -> list[Decision]:
    """Return decisions in the order in which rims are put on other faults: the nearest first.

    Before them come rims that lie on each other: once they have common edges, a third fault on which both
    lie gets one line of them, and not two a snap apart.
    """
    joins = {(d.own, other) for d in decisions if d.what is What.JOIN for other in d.others}
    each_other = {(own, other) for own, other in joins if (other, own) in joins}
    return sorted(decisions, key=lambda d: (each_other.isdisjoint((d.own, k) for k in d.others), d.size))


def linked(task: Task, decisions: Iterable[Decision]) -> list[list[int]]:
    """Return the groups of faults that must be worked on together, by position.

    They are linked by a finding, by what is to be done, and by edges that they share already.
    """
    names = {f.name: k for k, f in enumerate(task.model.faults)}
    pairs = [(d.own, other) for d in decisions for other in d.others]
    asked = {k for pair in pairs for k in pair}
    for finding in task.findings:
        members = [names[n] for n in finding.objects if n in names]
        pair = frozenset(task.model.faults[k].name for k in members)
        vetoed = pair in task.vetoed or (len(pair) == 2 and task.rule(*pair) == "forbid")
        if len(members) == 2 and finding.check == "simplicial-complex" and not vetoed:
            pairs.append((members[0], members[1]))
            asked.update(members)
    if not pairs:
        return []
    shared = [c.surfaces for c in task.evidence.contacts if c.kind is ContactKind.EDGE]
    label = components(len(names), np.array([*pairs, *shared]))
    groups = [np.flatnonzero(label == k).tolist() for k in np.unique(label[sorted(asked)])]
    return [g for g in groups if len(g) > 1]
