"""Runs checks and keeps what they say; on large horizons, a part of them beside the rest of a look."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from graben.beside import begun
from graben.finding import Finding, Profile, Status, Worst
from graben.validators.context import Check, CheckContext, Defect, Need, Severity

#: Triangles of all horizons from which on a copy of the process takes a part of the checks.
_LARGE = 200_000

#: What a check says: all findings, and those of them that block modeling.
_Said = tuple[list[Finding], list[Finding]]


class Course:
    """The checks of one look at a model, as far as they have run.

    Parameters
    ----------
    checks : sequence of Check
        Those to run.
    profile : Profile
        Which defects fail.
    context : CheckContext
        What they see; it is replaced as more is known.

    Attributes
    ----------
    said : dict of str to list of Finding
        What they found, by the id of the check.
    """

    def __init__(self, checks: Sequence[Check], profile: Profile, context: CheckContext) -> None:
        self.context = context
        self.said: dict[str, list[Finding]] = {}
        self._profile = profile
        self._checks = {need: [c for c in checks if (c.stage or c.need) is need] for need in Need}
        self._blocking: dict[str, list[Finding]] = {}
        self._begun: Callable[[], list[dict[str, _Said]]] | None = None
        self._large = sum(len(h.surface.triangles) for h in context.model.horizons) > _LARGE

    def run(self, need: Need) -> None:
        """Run the checks of a stage; on large horizons what may take long is begun only: see :meth:`join`."""
        due = self._checks[need]
        if need is Need.SURFACES:
            due = [c for c in due if c.id != "finite"]
            self._keep(self._found([c for c in self._checks[need] if c.id == "finite"], self.context))
            unfit = {name for f in self.said.get("finite", ()) for name in f.objects}
            sound = frozenset(s.name for s in self.context.model.surfaces) - unfit
            self.context = replace(self.context, sound=sound)
        if not self._large:
            self._keep(self._found(due, self.context))
        elif need is Need.SURFACES:
            horizons = frozenset(h.name for h in self.context.model.horizons)
            # what one measures of a horizon the others use: two processes would measure it twice
            self._begin([due], replace(self.context, asked=horizons))
            others = self.context.sound - horizons
            self._keep(self._found(due, replace(self.context, asked=others)))
        else:
            self._begin([[c] for c in due if c.long], self.context)
            self._keep(self._found([c for c in due if not c.long], self.context))

    @property
    def waits(self) -> bool:
        """Whether checks run beside."""
        return self._begun is not None

    def join(self) -> None:
        """Wait for what was begun, and keep what it says."""
        if self._begun is not None:
            found, self._begun = self._begun(), None
            self._keep({check: said for own in found for check, said in own.items()})

    def _begin(self, groups: Sequence[Sequence[Check]], context: CheckContext) -> None:
        """Begin groups of checks beside what follows, where there are any."""
        if groups:
            self.join()
            self._begun = begun([partial(self._found, checks, context) for checks in groups])

    def _found(self, checks: Sequence[Check], context: CheckContext) -> dict[str, _Said]:
        return {check.id: _findings(check, context, self._profile) for check in checks}

    def _keep(self, found: dict[str, _Said]) -> None:
        """Add what checks say; what stands against modeling is put in the order in which checks run."""
        for check, (said, blocks) in found.items():
            # what comes later was begun earlier: it is of horizons, which checks look at first
            self.said[check] = [*said, *self.said.get(check, ())]
            self._blocking[check] = [*blocks, *self._blocking.get(check, ())]
        order = [check.id for checks in self._checks.values() for check in checks]
        blocking = tuple(f for name in order for f in self._blocking.get(name, ()))
        self.context = replace(self.context, evidence=replace(self.context.evidence, blocking=blocking))


def _findings(check: Check, context: CheckContext, profile: Profile) -> _Said:
    """Return the findings of a check, and those of them that block modeling."""
    defects = check.run(context)
    findings = [_finding(check, d, profile) for d in defects]
    return findings, [f for f, d in zip(findings, defects, strict=True) if d.blocks]


def _finding(check: Check, defect: Defect, profile: Profile) -> Finding:
    severity = defect.severity or check.severity
    warns = severity is Severity.WARN or (severity is Severity.RELAXED and profile is Profile.EXTENDED)
    worst = None
    if defect.value is not None and defect.place is not None:
        x, y, z = (float(c) for c in defect.place)
        worst = Worst(float(defect.value), defect.unit, x, y, z)
    return Finding(
        check.id,
        Status.WARN if warns else Status.FAIL,
        defect.objects,
        int(defect.count),
        worst,
        defect.message,
        defect.remedy,
        check.repairable,
        defect.elements,
        defect.places,
        defect.element,
        defect.paths,
        defect.parts,
    )
