"""The parts of the report of `graben check`: its findings, check by check, in words."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from graben.finding import Element, Finding, Status
from graben.reports.check_view3d import view_space
from graben.reports.check_words import measured_words, seen
from graben.reports.marks import LETTERS, reach_of
from graben.reports.scenery import Scenery
from graben.reports.style import rounded
from graben.validators.context import Check, Scope
from graben.validators.registry import CHECKS
from graben.words import plural

if TYPE_CHECKING:
    from graben.surface import Surface

#: Rows of a table, places and elements of a finding, and letters of a text, that are listed.
MOST_ROWS = 200
_MOST_PLACES, _MOST_ELEMENTS, _MOST_LETTERS = 12, 8, 600
#: Square metres from which on areas are told in square kilometres.
_LARGE_AREA = 1e5


def known_checks() -> Mapping[str, Check]:
    """Return the checks of the registry by their ids."""
    return {check.id: check for check in CHECKS}


def told(text: str) -> str:
    """Return a text as the page shows it: nothing that steers the reader's screen, and not without end."""
    shown = seen(text)
    return shown if len(shown) <= _MOST_LETTERS else f"{shown[: _MOST_LETTERS - 1]}…"


def counts(findings: Iterable[Finding]) -> str:
    """Return how many findings fail and warn, as in "2 failures, 1 warning"."""
    found = [f.status for f in findings]
    named = (
        plural(found.count(s), word)
        for s, word in ((Status.FAIL, "failure"), (Status.WARN, "warning"))
        if s in found
    )
    return ", ".join(named)


def check_groups(
    scenery: Scenery, numbered: Mapping[int, Finding], shown: Collection[int]
) -> list[dict[str, Any]]:
    """Return what the page says of the findings, check by check, in the table's order.

    Parameters
    ----------
    scenery : Scenery
        The model.
    numbered : mapping of int to Finding
        The findings that warn or fail, by their numbers.
    shown : collection of int
        The numbers of those that get a part of their own.
    """
    known = known_checks()
    groups = []
    for check in dict.fromkeys(f.check for f in numbered.values()):
        own = {n: f for n, f in numbered.items() if f.check == check}
        rows = [_row(scenery, n, f, n in shown) for n, f in own.items()]
        more = len(rows) - MOST_ROWS
        about = known.get(check)
        groups.append(
            {
                "id": check,
                "anchor": f"check-{check}",
                "findings": counts(own.values()),
                "sentence": about.sentence if about else "",
                "why": about.why if about else "",
                "section": f"paper, section {about.section}" if about else "",
                "blocks": _blocks(about) if about else "",
                "rows": rows[:MOST_ROWS] if len(rows) > 1 else [],
                "more": f"{plural(more, 'more finding')}: all are in the JSON." if more > 0 else "",
                "parts": [
                    {**row, **_part(scenery, own[row["number"]])} for row in rows if row["number"] in shown
                ],
            }
        )
    return groups


def _blocks(check: Check) -> str:
    """Return what a failure keeps from being modeled."""
    if check.scope is Scope.NOTHING:
        return "Blocks nothing: what can be modeled is modeled."
    if check.blocks_when:
        return f"What blocks the modeling of {check.scope.value}: {check.blocks_when}."
    return f"A failure blocks the modeling of {check.scope.value}."


def _row(scenery: Scenery, number: int, finding: Finding, shown: bool) -> dict[str, Any]:
    return {
        "number": number,
        "anchor": f"finding-{number}",
        "shown": shown,
        "status": str(finding.status),
        "objects": told(", ".join(finding.objects)),
        "message": told(finding.message),
        "worst": _worst(scenery, finding),
    }


def _part(scenery: Scenery, finding: Finding) -> dict[str, Any]:
    """Return what the part of a finding shows beside its row."""
    marks = scenery.marks(finding)
    space = view_space(scenery) if scenery.shapes else None
    place = ""
    if space is not None and marks.worst is not None:
        place = " ".join(f"{c:.9g}" for c in space.local(marks.worst[None])[0])
    edges = [scenery.shapes[n].median_edge for n in finding.objects if n in scenery.shapes]
    return {
        "where": _where(scenery, finding),
        "place": place,
        "reach": f"{max([reach_of(marks.everything), *(3 * e for e in edges)]):.6g}",
        **_places(scenery, finding),
        "remedy": told(finding.remedy),
        "repairable": finding.repairable,
        "elements": _elements(scenery, finding),
        **_parts(scenery, finding),
    }


def _worst(scenery: Scenery, finding: Finding) -> str:
    """Return the worst value of a finding and its place, or its first place, in words; else nothing."""
    w = finding.worst
    if w is not None:
        value = f"{measured_words(finding)}{sized(w.value, w.unit)}"
        return f"{value} at {scenery.frame.place((w.x, w.y, w.z), scenery.step)}"
    return f"at {scenery.frame.place(finding.places[0], scenery.step)}" if len(finding.places) else ""


def sized(value: float | None, unit: str) -> str:
    """Return a value with its unit; large areas in square kilometres.

    >>> sized(77_815_144.0, "m²"), sized(3.5, "m"), sized(None, "")
    ('77.8 km²', '3.5 m', '')
    """
    if value is None:
        return ""
    if unit == "m²" and abs(value) >= _LARGE_AREA:
        value, unit = value * 1e-6, "km²"
    return f"{rounded(value)} {unit}".rstrip()


def _where(scenery: Scenery, finding: Finding) -> str:
    worst = _worst(scenery, finding)
    if not worst:
        return "No single place."
    many = len(finding.places) + len(finding.paths) > 1
    return (
        f"{'Worst' if many else 'At'}: {worst.removeprefix('at ')}."
        if finding.worst
        else f"{worst.capitalize()}."
    )


def _places(scenery: Scenery, finding: Finding) -> dict[str, Any]:
    """Return the first places of a finding that has several."""
    places = finding.places
    if len(places) < 2:
        return {"places": [], "places_title": ""}
    first = [scenery.frame.place(p, scenery.step) for p in places[:_MOST_PLACES]]
    rest = (
        f"the first {len(first)} of {len(places)}; the GeoJSON has more"
        if len(places) > len(first)
        else f"all {len(places)}"
    )
    return {"places": first, "places_title": f"Places ({rest})"}


def _elements(scenery: Scenery, finding: Finding) -> str:
    """Return the first elements concerned and, for triangles, their lines in the file."""
    if finding.element is Element.NONE or not len(finding.elements):
        return ""
    named = finding.elements[:_MOST_ELEMENTS].tolist()
    surface = next((s for s in scenery.model.surfaces if s.name in finding.objects[:1]), None)
    words = [f"{e}{_line(surface, e) if finding.element is Element.TRIANGLE else ''}" for e in named]
    more = len(finding.elements) - len(named)
    tail = f" and {more} more" if more else ""
    file = surface.file.name if surface is not None and surface.file is not None else ""
    of = f" of {file}" if file and any("line" in w for w in words) else ""
    count = plural(len(finding.elements), str(finding.element)).replace("vertexs", "vertices")
    return told(f"{count}{of}: {', '.join(words)}{tail}, counted from 0.")


def _line(surface: Surface | None, triangle: int) -> str:
    if surface is None or not 0 <= triangle < len(surface.lines):
        return ""
    return f" (line {surface.lines[triangle]})"


def _parts(scenery: Scenery, finding: Finding) -> dict[str, Any]:
    """Return the table of what a finding consists of."""
    parts = finding.parts[:MOST_ROWS]
    letters: Sequence[str] = LETTERS if len(finding.parts) > 1 else ""
    rows = [
        {
            "letter": letters[k] if k < len(letters) else "",
            "kind": told(p.kind),
            "objects": told(", ".join(p.objects)),
            "count": p.count,
            "size": sized(p.value, p.unit),
            "place": scenery.frame.place(p.place, scenery.step),
        }
        for k, p in enumerate(parts)
    ]
    more = len(finding.parts) - len(parts)
    only = rows.pop() if len(rows) == 1 else None
    return {
        "only": ", ".join(str(only[k]) for k in ("kind", "objects", "size") if only[k]) if only else "",
        "rows": rows,
        "rows_objects": any(p.objects for p in parts),
        "rows_more": f"{more} more: all are in the JSON." if more else "",
    }
