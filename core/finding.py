"""What a check says: findings, and the verdict they add up to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints

if TYPE_CHECKING:
    import pyvista


class Status(StrEnum):
    """Outcome of a check on its objects."""

    PASS = "pass"
    WARN = "warn"
    FAIL = "fail"
    SKIPPED = "skipped"


class Profile(StrEnum):
    """Which conditions block: the paper's own, or those this program really needs."""

    PAPER = "paper"
    EXTENDED = "extended"


@dataclass(frozen=True)
class Worst:
    """The worst value of a finding and its place: x, y and elevation, model units."""

    value: float
    unit: str
    x: float
    y: float
    z: float


@dataclass(frozen=True, eq=False)
class Finding:
    """What one check says of one object or pair of objects.

    Parameters
    ----------
    check : str
        Id of the check.
    status : Status
        Outcome.
    objects : tuple of str
        Names of the surfaces concerned.
    count : int
        How many elements are concerned.
    worst : Worst or None
        Worst value and its place.
    message, remedy : str
        One sentence each: what is wrong, what to do.
    repairable : bool
        Whether `graben repair` has an answer.
    elements : (k,) array
        Indices of the elements concerned (the message says of what), of the first object.
    places : (p, 3) array
        x, y and elevation of the places concerned, model units.
    """

    check: str
    status: Status
    objects: tuple[str, ...] = ()
    count: int = 0
    worst: Worst | None = None
    message: str = ""
    remedy: str = ""
    repairable: bool = False
    elements: IntArray = field(default_factory=lambda: ints([]))
    places: FloatArray = field(default_factory=lambda: floats([], 0, 3))

    def as_dict(self, z_factor: float = 1.0) -> dict[str, Any]:
        """Return the finding for JSON; ``z_factor`` -1 turns elevations into depths."""
        worst = None
        if self.worst is not None:
            w = self.worst
            worst = {"value": w.value, "unit": w.unit, "x": w.x, "y": w.y, "z": z_factor * w.z}
        return {
            "check": self.check,
            "status": str(self.status),
            "objects": list(self.objects),
            "count": self.count,
            "worst": worst,
            "message": self.message,
            "remedy": self.remedy,
            "repairable": self.repairable,
        }


@dataclass(frozen=True, eq=False)
class CheckResult:
    """The findings of a model under a profile, in the order of the registry; ``z_factor`` is for output."""

    profile: Profile
    findings: tuple[Finding, ...]
    z_factor: float = 1.0

    @property
    def passed(self) -> bool:
        """Whether no finding fails; warnings and skipped checks never fail."""
        return all(f.status is not Status.FAIL for f in self.findings)

    def of(self, check: str) -> tuple[Finding, ...]:
        """Return the findings of the check with this id."""
        return tuple(f for f in self.findings if f.check == check)

    def as_dict(self) -> dict[str, Any]:
        """Return the verdict for JSON."""
        return {
            "schema": 1,
            "profile": str(self.profile),
            "passed": self.passed,
            "findings": [f.as_dict(self.z_factor) for f in self.findings],
        }

    def counts(self) -> Mapping[Status, int]:
        """Return the number of findings of each status."""
        return {s: sum(f.status is s for f in self.findings) for s in Status}

    def __repr__(self) -> str:
        verdict = "passed" if self.passed else "not passed"
        lines = [f"Check ({self.profile}): {verdict}"]
        lines += [
            f"  {f.status:<7} {f.check:<20} {', '.join(f.objects)}: {f.message}"
            for f in self.findings
            if f.status in (Status.FAIL, Status.WARN)
        ]
        return "\n".join(lines)

    def to_pyvista(self) -> pyvista.MultiBlock:
        """Return the places of the findings, a named block of points for each that has any."""
        import pyvista

        blocks = pyvista.MultiBlock()
        for finding in self.findings:
            if len(finding.places):
                points = pyvista.PolyData(np.array(finding.places))
                points.field_data["status"] = [str(finding.status)]
                blocks.append(points, " ".join((finding.check, *finding.objects)))
        return blocks

    def _repr_html_(self) -> str:
        from html import escape

        rows = "".join(
            f"<tr><td>{f.status}</td><td>{f.check}</td><td>{escape(', '.join(f.objects))}</td>"
            f"<td>{escape(f.message)}</td><td>{escape(f.remedy)}</td></tr>"
            for f in self.findings
        )
        head = "<tr><th>status</th><th>check</th><th>objects</th><th>message</th><th>remedy</th></tr>"
        return f"<p>Check: <b>{'passed' if self.passed else 'not passed'}</b></p><table>{head}{rows}</table>"
