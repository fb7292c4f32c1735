"""What a check says: findings, and the verdict they add up to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np

from graben.arrays import FloatArray, IntArray, floats, ints
from graben.notebook import html_table

if TYPE_CHECKING:
    import pandas
    import pyvista

#: So many parts of a finding are shown in a notebook.
_MOST_PARTS = 20


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

    @classmethod
    def _missing_(cls, value: object) -> Profile:
        raise ValueError(f"There is no profile {value!r}: it is {' or '.join(repr(str(p)) for p in cls)}.")


class Element(StrEnum):
    """What the element indices of a finding number."""

    NONE = ""
    VERTEX = "vertex"  #: of the first object
    TRIANGLE = "triangle"  #: of the first object
    PICK = "pick"  #: input points of the horizon
    NODE = "node"  #: of the cut graph
    EDGE = "edge"  #: of the cut graph
    SUBDOMAIN = "subdomain"  #: of the cut horizon


@dataclass(frozen=True)
class Part:
    """One kind of thing within a finding, such as a gap, a proper crossing or a cycle.

    Parameters
    ----------
    kind : str
        What it is, in a few words.
    count : int
        How many elements it has.
    place : tuple of float
        x, y and elevation of it, model units.
    value, unit : float or None, str
        Its size, where it has one: a length, a distance, an area.
    objects : tuple of str
        Names of the surfaces that it is about, where they are not those of the finding, in their order.
    """

    kind: str
    count: int
    place: tuple[float, float, float]
    value: float | None = None
    unit: str = ""
    objects: tuple[str, ...] = ()

    def moved(self, offset: FloatArray) -> Part:
        """Return the part with its place moved by ``offset``, shape (3,)."""
        x, y, z = (float(c) for c in np.array(self.place) + offset)
        return replace(self, place=(x, y, z))


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
        Indices of the elements concerned.
    element : Element
        What ``elements`` number.
    places : (p, 3) array
        x, y and elevation of the places concerned, model units.
    paths : tuple of (k, 3) arrays
        Lines concerned, such as a stretch of a rim or a cycle of cuts, model units.
    parts : tuple of Part
        What the finding consists of, where that is of several kinds or sizes.
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
    element: Element = Element.NONE
    paths: tuple[FloatArray, ...] = ()
    parts: tuple[Part, ...] = ()

    def moved(self, offset: FloatArray) -> Finding:
        """Return the finding with all its places moved by ``offset``, shape (3,), model units."""
        worst = self.worst
        if worst is not None:
            x, y, z = (float(c) for c in np.array([worst.x, worst.y, worst.z]) + offset)
            worst = replace(worst, x=x, y=y, z=z)
        return replace(
            self,
            worst=worst,
            places=floats(self.places + offset),
            paths=tuple(floats(path + offset) for path in self.paths),
            parts=tuple(part.moved(offset) for part in self.parts),
        )

    def __repr__(self) -> str:
        about = f" {', '.join(self.objects)}" if self.objects else ""
        return f"Finding: {self.status} {self.check}{about}: {self.message}"

    def _repr_html_(self) -> str:
        worst = "" if self.worst is None else f"{self.worst.value:.4g} {self.worst.unit}".rstrip()
        rows = [
            ("objects", ", ".join(self.objects)),
            ("count", self.count),
            ("worst", worst),
            ("message", self.message),
            ("remedy", self.remedy),
            *((part.kind, f"{part.count}, at {part.place}") for part in self.parts[:_MOST_PARTS]),
        ]
        return html_table((f"{self.status}: {self.check}", ""), rows)

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
            "parts": [
                {
                    "kind": p.kind,
                    "count": p.count,
                    "objects": list(p.objects or self.objects),
                    "value": p.value,
                    "unit": p.unit,
                    "x": p.place[0],
                    "y": p.place[1],
                    "z": z_factor * p.place[2],
                }
                for p in self.parts
            ],
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

    @property
    def warned(self) -> bool:
        """Whether some finding warns."""
        return any(f.status is Status.WARN for f in self.findings)

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

    def table(self) -> pandas.DataFrame:
        """Return the findings as a table: see :func:`graben.finding_table.findings_table`."""
        from graben.finding_table import findings_table

        return findings_table(self)

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

        def worst(w: Worst | None) -> str:
            if w is None:
                return ""
            return escape(f"{w.value:.4g} {w.unit} at {w.x:.2f}, {w.y:.2f}, {self.z_factor * w.z:.2f}")

        rows = "".join(
            f"<tr><td>{f.status}</td><td>{f.check}</td><td>{escape(', '.join(f.objects))}</td>"
            f"<td>{f.count or ''}</td><td>{worst(f.worst)}</td>"
            f"<td>{escape(f.message)}</td><td>{escape(f.remedy)}</td></tr>"
            for f in self.findings
        )
        names = ("status", "check", "objects", "count", "worst, at x, y, z", "message", "remedy")
        head = f"<tr>{''.join(f'<th>{name}</th>' for name in names)}</tr>"
        return f"<p>Check: <b>{'passed' if self.passed else 'not passed'}</b></p><table>{head}{rows}</table>"
