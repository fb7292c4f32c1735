"""From findings to repairs: each acts on what asks for it, proves itself by the checks, or is undone.

One round goes through the registry in its order. The changes of a repair are made together, the model is
checked again as far as the repair must see, and what did not help, or went beyond its limits, is undone.
Rounds follow each other until nothing changes.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from graben.cleaning.ledger import Left, RepairAction, measured, place_of
from graben.cleaning.notes import Notes
from graben.cleaning.registry import REPAIRS
from graben.cleaning.repairing import Change, Refusal, Repair, Step, Task
from graben.cleaning.shaping.limits import ROUNDING, distances, joined
from graben.cleaning.side_effects import grown, worsened
from graben.finding import CheckResult, Finding, Status
from graben.model import Fault, Model
from graben.surface import Surface
from graben.validators.context import Evidence, Need, Severity
from graben.validators.registry import CHECKS
from graben.words import plural

#: Checks a model as far as a stage, of the checks that can only warn those named; in the model's own frame.
Gate = Callable[[Model, Need, frozenset[str]], tuple[CheckResult, Evidence]]
#: Called with the repair and what it works on, for a progress display.
Progress = Callable[[str, str], None]

#: What tells a finding from others, see :func:`_key`.
_Key = tuple[str, tuple[str, ...], int, str]
#: Ids of the checks that can only warn.
_WARNING = frozenset(check.id for check in CHECKS if check.severity is Severity.WARN)
#: After so many rounds the plan ends; a network needs two or three.
MOST_ROUNDS = 4
#: So often a repair is asked again without what did not help.
MOST_TRIES = 3


@dataclass(frozen=True, eq=False)
class Repaired:
    """What a plan came to, in the frame it was made in.

    Parameters
    ----------
    model : Model
        With the repaired faults.
    actions : tuple of RepairAction
        What was done, in order.
    left : tuple of Left
        What repairs looked at and left; findings without any repair are not among them.
    lineage : mapping of str to str
        By the name of each fault of the model: the fault of the input that it came from.
    """

    model: Model
    actions: tuple[RepairAction, ...]
    left: tuple[Left, ...]
    lineage: Mapping[str, str]


def repaired(model: Model, gate: Gate, progress: Progress, found: tuple[CheckResult, Evidence]) -> Repaired:
    """Return the model with what asks for repair repaired as far as that goes.

    Parameters
    ----------
    model : Model
        In its local frame.
    gate : callable
        Checks a model.
    progress : callable
        Told of each repair.
    found : tuple of CheckResult and Evidence
        What the gate says of the model, all stages.
    """
    # the limits are those of the faults that were given, however fine or coarse repairs make them
    held = replace(model, faults=tuple(replace(f, max_move=model.max_move(f)) for f in model.faults))
    work = _Work(held, gate, found)
    for _ in range(MOST_ROUNDS):
        before = work.model
        for repair in REPAIRS:
            if repair.id not in model.repair.skip:
                work.attempt(repair, progress)
        if work.model is before:
            break
    return Repaired(
        model if work.model is held else work.model,
        tuple(work.actions),
        work.notes.all(),
        MappingProxyType(dict(work.lineage)),
    )


class _Work:
    """The state of a plan: the model so far, what was done to it, and what was tried in vain."""

    def __init__(self, model: Model, gate: Gate, found: tuple[CheckResult, Evidence]) -> None:
        self.model = model
        self.actions: list[RepairAction] = []
        self.notes = Notes()
        self.lineage = {f.name: f.name for f in model.faults}
        self._references = {f.name: f.surface for f in model.faults}
        self._gate = gate
        self._seen = (model, Need.ANCHORS, _WARNING, *found)
        #: by repair: the findings that it has seen and left
        self._settled: dict[str, set[_Key]] = {}
        #: by repair and names: the surfaces on which it was tried in vain
        self._vain: dict[tuple[str, frozenset[str]], tuple[Surface, ...]] = {}

    def attempt(self, repair: Repair, progress: Progress) -> None:
        """Let one repair do what helps, asking it again about the faults of what does not."""
        result, evidence = self._checked(repair)
        # what it has left once is not tried again as long as it is found alike
        findings = self._open(repair, result)
        looked: set[_Key] = set()
        for _ in range(MOST_TRIES):
            if not findings or (repair.need >= Need.COMPLEX and evidence.complex is None):
                break
            progress("repair", f"{repair.id}, {plural(len(findings), 'finding')}")
            vetoed = self._vetoed(repair)
            self.notes.forget(repair, (f for f in findings if self._faults_of(f) not in vetoed))
            proposed = repair.propose(
                Task(self.model, findings, evidence, MappingProxyType(dict(self._references)), vetoed)
            )
            for refusal in proposed:
                if isinstance(refusal, Refusal):
                    self.notes.leave(repair, refusal)
            possible = [c for c in proposed if isinstance(c, Change) and frozenset(c.surfaces) not in vetoed]
            changes = _disjoint(possible)
            # a change of faults that another one takes first waits for the next try
            again = {name for c in possible if c not in changes for name in c.surfaces}
            looked.update(_key(f) for f in findings if not again.intersection(f.objects))
            again |= self._judged(repair, changes, findings, result)
            if not again:
                break
            result, evidence = self._checked(repair)
            findings = tuple(f for f in self._open(repair, result) if again.intersection(f.objects))
        self._settled.setdefault(repair.id, set()).update(looked)

    def _judged(
        self, repair: Repair, changes: list[Change], findings: Sequence[Finding], before: CheckResult
    ) -> frozenset[str]:
        """Keep of some changes those that help; return the faults of the others."""
        asked = _WARNING.intersection(repair.checks)
        undone = [c for c in changes if self._beyond(repair, c, findings)]
        changes = [c for c in changes if c not in undone]
        while changes:
            trial = _applied(self.model, changes)
            after, evidence = self._gate(trial, repair.need, asked)
            # what keeps the faults from being looked at together hides findings, and does not help
            blind = repair.need >= Need.COMPLEX and evidence.complex is None
            bad = [c for c in changes if blind or not self._helps(repair, c, before, after)]
            for change in bad:
                self._in_vain(repair, change, findings, before, after)
            if not bad:
                self._accept(repair, changes, trial)
                self._seen = (trial, repair.need, asked, after, evidence)
                break
            undone += bad
            changes = [c for c in changes if c not in bad]
        return frozenset(name for change in undone for name in change.surfaces)

    def _asking(self, repair: Repair, result: CheckResult) -> tuple[Finding, ...]:
        return tuple(f for f in result.findings if _asks(repair, f, self.model))

    def _open(self, repair: Repair, result: CheckResult) -> tuple[Finding, ...]:
        """Return the findings that ask for a repair and that it has not left before."""
        settled = self._settled.get(repair.id, set())
        return tuple(f for f in self._asking(repair, result) if _key(f) not in settled)

    def _checked(self, repair: Repair) -> tuple[CheckResult, Evidence]:
        """Return the findings as far as a repair must see them, made anew only where something is missing."""
        model, need, warning = self._seen[:3]
        asked = _WARNING.intersection(repair.checks)
        if model is not self.model or need < repair.need or not asked <= warning:
            self._seen = (self.model, repair.need, asked, *self._gate(self.model, repair.need, asked))
        return self._seen[3], self._seen[4]

    def _vetoed(self, repair: Repair) -> frozenset[frozenset[str]]:
        """Return what a repair was tried on in vain, where the surfaces are still the same."""
        now = {f.name: f.surface for f in self.model.faults}
        return frozenset(
            names
            for (tried, names), surfaces in self._vain.items()
            if tried == repair.id and all(now.get(s.name) is s for s in surfaces)
        )

    def _beyond(self, repair: Repair, change: Change, findings: Sequence[Finding]) -> bool:
        """Return whether a change moves a vertex further than allowed, and note it."""
        for old, new in change.surfaces.items():
            limit = self.model.max_move(self._fault(old))
            for surface in new:
                away = distances(surface, self._measured_from(old, surface.name, change))
                far = int(np.argmax(away)) if len(away) else 0
                if len(away) and away[far] > limit * (1.0 + ROUNDING):
                    self._give_up(repair, change, {old}, findings)
                    reason = (
                        f"{repair.id} would move {old} by {away[far]:.3g}, more than max_move = {limit:.3g}."
                    )
                    self.notes.leave_all(
                        repair,
                        change,
                        findings,
                        Refusal(
                            change.steps[0].check,
                            change.steps[0].objects,
                            reason,
                            "Raise max_move in [repair], or repair it by hand.",
                            surface.vertices[far],
                            float(away[far] - limit),
                            "model units",
                        ),
                    )
                    return True
        return False

    def _measured_from(self, old: str, new: str, change: Change) -> list[Surface]:
        added = [change.declared[name] for name in (old, new) if name in change.declared]
        return [self._references[old], *added]

    def _helps(self, repair: Repair, change: Change, before: CheckResult, after: CheckResult) -> bool:
        """Return whether the findings that a change answers shrink, and no more checks fail than before.

        Of a surface that no check could look at, more becomes known once they can. What mends warnings alone
        must not make others worse by more than it mends.
        """
        old = frozenset(change.surfaces)
        new = frozenset(s.name for made in change.surfaces.values() for s in made) | old
        own = [
            _trouble(f for f in result.findings if _asks(repair, f, self.model) and names & set(f.objects))
            for result, names in ((before, old), (after, new))
        ]
        if own[1] >= own[0]:
            return False
        horizons = {h.name for h in self.model.horizons}
        fails = [
            sum(1 for f in result.findings if _counts(f, names, horizons))
            for result, names in ((before, old), (after, new))
        ]
        if "finite" not in repair.checks and fails[1] > fails[0]:
            return False
        warned = own[0][0] == 0 and own[1][0] == 0
        return not warned or worsened(repair.checks, new, before, after) <= 0.0

    def _in_vain(
        self,
        repair: Repair,
        change: Change,
        findings: Sequence[Finding],
        before: CheckResult,
        after: CheckResult,
    ) -> None:
        """Note what of a change did not help: pairs of faults that are worse now, or else all of it."""
        names = frozenset(s.name for made in change.surfaces.values() for s in made) | set(change.surfaces)
        known = {(f.check, f.objects): _trouble([f]) for f in _failing(before, names)}
        worse = [f for f in _failing(after, names) if _trouble([f]) > known.get((f.check, f.objects), ())]
        self._give_up(repair, change, {name for f in worse for name in f.objects}, findings)
        worse = worse or grown(repair.checks, names, before, after)
        said = f" Then: {worse[0].message}" if worse else ""
        together = len(change.surfaces)
        what = f"{repair.id} was tried" + (f" on {together} faults that meet" if together > 2 else "")
        step = change.steps[0]
        reason = f"{what}, and undone, since it did not help.{said}"
        self.notes.leave_all(repair, change, findings, Refusal(step.check, step.objects, reason))

    def _give_up(
        self, repair: Repair, change: Change, guilty: Collection[str], findings: Iterable[Finding]
    ) -> None:
        """Keep a repair off pairs of faults with some that were worse for it, or off all that it changed."""
        faults = {f.name: f.surface for f in self.model.faults}
        whole = frozenset(change.surfaces)
        pairs = {self._faults_of(f) for f in findings}
        pairs = {p for p in pairs if len(p) > 1 and p < whole and p.intersection(guilty)}
        for group in pairs or {whole}:
            self._vain[repair.id, group] = tuple(faults[name] for name in sorted(group))

    def _accept(self, repair: Repair, changes: Sequence[Change], trial: Model) -> None:
        """Take the changes over and write the ledger."""
        for change in changes:
            old = [self._fault(name).surface for name in change.surfaces]
            new = [s for made in change.surfaces.values() for s in made]
            moves = {name: self._moved(name, made, change) for name, made in change.surfaces.items()}
            before, after = tuple(map(measured, old)), tuple(map(measured, new))
            for step in _all_steps(change):
                self.actions.append(
                    RepairAction(
                        repair.id,
                        step.check,
                        step.objects,
                        step.count,
                        max((moves[name] for name in step.objects if name in moves), default=0.0),
                        place_of(step.place),
                        step.reason,
                        step.size,
                        step.unit,
                        before,
                        after,
                    )
                )
        for change in changes:
            for name, made in change.surfaces.items():
                reference, origin = self._references.pop(name), self.lineage.pop(name)
                for surface in made:
                    extra = [
                        change.declared[n]
                        for n in dict.fromkeys((name, surface.name))
                        if n in change.declared
                    ]
                    for patch in extra:
                        reference = joined(reference, patch)
                    self._references[surface.name] = replace(reference, name=surface.name)
                    self.lineage[surface.name] = origin
        self.model = trial

    def _moved(self, old: str, made: Sequence[Surface], change: Change) -> float:
        """Return how far a change moves a vertex off a fault as it was and what it adds to it."""
        most = 0.0
        for surface in made:
            added = [change.declared[name] for name in (old, surface.name) if name in change.declared]
            away = distances(surface, [self._fault(old).surface, *added])
            most = max(most, float(away.max(initial=0.0)))
        return most

    def _faults_of(self, finding: Finding) -> frozenset[str]:
        return frozenset(f.name for f in self.model.faults if f.name in finding.objects)

    def _fault(self, name: str) -> Fault:
        return next(f for f in self.model.faults if f.name == name)


def _asks(repair: Repair, finding: Finding, model: Model) -> bool:
    """Return whether a finding asks for a repair: of its checks, wanted, and of a fault or a cut graph."""
    wanted = finding.check in repair.checks and repair.answers(finding, model)
    of_faults = bool({f.name for f in model.faults}.intersection(finding.objects))
    return wanted and (of_faults or repair.need >= Need.GRAPH)


def _key(finding: Finding) -> _Key:
    """Return what tells a finding from others: where its count or its size changes it is another."""
    size = "" if finding.worst is None else f"{finding.worst.value:.3g}"
    return finding.check, finding.objects, finding.count, size


def _trouble(findings: Iterable[Finding]) -> tuple[float, ...]:
    """Return how bad some findings are: how many fail, how many there are, and what they count."""
    own = list(findings)
    return (
        float(sum(f.status is Status.FAIL for f in own)),
        float(len(own)),
        float(sum(f.count for f in own)),
    )


def _counts(finding: Finding, names: Iterable[str], horizons: set[str]) -> bool:
    """Return whether a finding fails and concerns some faults, or horizons alone: a cycle, a part unheld."""
    concerned = bool(set(names).intersection(finding.objects)) or set(finding.objects) <= horizons
    return finding.status is Status.FAIL and concerned


def _failing(result: CheckResult, names: Iterable[str]) -> list[Finding]:
    """Return the findings that fail and concern one of some surfaces."""
    some = set(names)
    return [f for f in result.findings if f.status is Status.FAIL and some.intersection(f.objects)]


def _all_steps(change: Change) -> tuple[Step, ...]:
    """Return the steps of a change, which name every surface that it changed.

    Parts of a fault that was split go with it; a fault that only got vertices of a line that another was
    given has a step of its own.
    """
    parts = {old: tuple(s.name for s in made if s.name != old) for old, made in change.surfaces.items()}
    steps = tuple(
        replace(
            step, objects=(*step.objects, *(part for name in step.objects for part in parts.get(name, ())))
        )
        for step in change.steps
    )
    told = {name for step in steps for name in step.objects}
    more = [
        Step(
            steps[0].check,
            (name,),
            sum(len(s.triangles) for s in made),
            None,
            f"{name} was divided anew into triangles along the lines in which it meets the others.",
        )
        for name, made in change.surfaces.items()
        if name not in told
    ]
    return (*steps, *more)


def _disjoint(changes: Iterable[Change]) -> list[Change]:
    """Return changes of which no two concern the same fault, those first proposed."""
    taken: set[str] = set()
    kept = []
    for change in changes:
        names = frozenset(change.surfaces)
        if not taken & names:
            taken |= names
            kept.append(change)
    return kept


def _applied(model: Model, changes: Sequence[Change]) -> Model:
    """Return the model with the changes made; parts of a split fault follow it."""
    made = {name: surfaces for change in changes for name, surfaces in change.surfaces.items()}
    faults: list[Fault] = []
    for fault in model.faults:
        if fault.name in made:
            faults += [replace(fault, surface=surface) for surface in made[fault.name]]
        else:
            faults.append(fault)
    return replace(model, faults=tuple(faults))
