"""What repairs left on the way, and why: one note for each repair and finding."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from graben.cleaning.ledger import Left, place_of
from graben.cleaning.repairing import Change, Refusal, Repair
from graben.finding import Finding


class Notes:
    """The notes of a plan, as far as it has come."""

    def __init__(self) -> None:
        self._left: dict[tuple[str, str, tuple[str, ...]], Left] = {}

    def all(self) -> tuple[Left, ...]:
        """Return the notes in the order in which they were first made."""
        return tuple(self._left.values())

    def forget(self, repair: Repair, findings: Iterable[Finding]) -> None:
        """Drop what a repair has left of findings that it looks at anew."""
        for finding in findings:
            self._left.pop((repair.id, finding.check, finding.objects), None)

    def leave(self, repair: Repair, refusal: Refusal) -> None:
        """Note what a repair says of a finding."""
        self._left[repair.id, refusal.check, refusal.objects] = Left(
            refusal.check,
            refusal.objects,
            repair.id,
            place_of(refusal.place),
            refusal.reason,
            refusal.advice,
            refusal.needed,
            refusal.unit,
        )

    def leave_all(
        self, repair: Repair, change: Change, findings: Iterable[Finding], refusal: Refusal
    ) -> None:
        """Note of each finding that a change was to answer why that was not done.

        What a repair has said itself of a finding says more, and stays.
        """
        asked = {step.check for step in change.steps}
        for finding in findings:
            concerned = finding.check in asked and change.surfaces.keys() & set(finding.objects)
            if concerned and (repair.id, finding.check, finding.objects) not in self._left:
                self.leave(repair, replace(refusal, check=finding.check, objects=finding.objects))
