"""The one-file report of `graben check`: verdict, checks, map, 3D view, and a part for each finding."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from graben.finding import Finding, Status
from graben.reports.check_figures import finding_picture
from graben.reports.check_map import overview
from graben.reports.check_parts import MOST_ROWS, check_groups, counts, known_checks, told
from graben.reports.check_view3d import check_scene
from graben.reports.check_words import counted, statuses, verdict
from graben.reports.page import Picture, picture, rendered
from graben.reports.scenery import Scenery
from graben.validators.registry import CHECKS
from graben.words import plural

if TYPE_CHECKING:
    from graben.model import Model
    from graben.pipeline import Examination
    from graben.surface import Surface

#: Findings with a part of their own; of each check the first, failures before warnings.
_MOST_PARTS = 50
#: Bytes of the page, with plotly.js (4.8 MB), of the pictures of all findings, and of the map.
_PAGE, _PICTURES, _MAP = 9_700_000, 2_700_000, 450_000
#: A picture may take so many times its even share of what is left.
_GENEROUS = 1.5
#: Meshes of more triangles are too large as drawings.
_DRAWN = 4_000
_OPEN = (Status.FAIL, Status.WARN)


def check_html(examination: Examination) -> str:
    """Return the report of an examination as one page that works offline, on paper and in the dark.

    Parameters
    ----------
    examination : Examination
        Of :func:`graben.pipeline.examine`.

    Returns
    -------
    str
        The page, at most 10 MB. Only the seconds and the peak memory differ between two examinations of the
        same model.
    """
    model, result = examination.model, examination.result
    scenery = Scenery.of(examination)
    told_of = [f for f in result.findings if f.status in _OPEN]
    failing = {f.check for f in told_of if f.status is Status.FAIL}
    told_of.sort(key=lambda f: f.check not in failing)  # checks that fail come first
    numbered = dict(enumerate(told_of, start=1))
    shown = _with_parts(numbered)
    facts = [plural(len(model.horizons), "horizon"), plural(len(model.faults), "fault")]
    facts += [
        f"profile {result.profile}",
        f"unit {model.unit}",
        f"z is {model.z}",
        *([model.crs] if model.crs else []),
    ]
    surfaces = _surfaces(model)
    more = f", the first {MOST_ROWS}" if len(surfaces) > MOST_ROWS else ""
    values: dict[str, Any] = {
        "title": told(model.name),
        "passed": result.passed,
        "verdict": told(verdict(result)),
        "facts": told(", ".join(facts)),
        "counted": told(counted(result)),
        "checks": _checks(examination),
        "left_out": _left_out(len(numbered), len(shown)),
        "about": _about(scenery, str(result.profile)),
        "tolerances": _tolerances(model),
        "surfaces": surfaces[:MOST_ROWS],
        "surfaces_title": plural(len(surfaces), "surface") + more,
        "seconds": f"{examination.seconds:.2f}",
        "memory": f"{examination.peak_memory_mb:.0f}",
    }
    scene, groups = check_scene(scenery, numbered), check_groups(scenery, numbered, shown)
    bare = rendered("check.html", scene, map=None, groups=groups, pictures={}, **values)
    room = _PAGE - len(bare.encode()) - _MAP
    pictures = _pictures(scenery, {n: f for n, f in numbered.items() if n in shown}, room)
    drawn = _map(scenery, numbered, shown)
    return rendered("check.html", scene, map=drawn, groups=groups, pictures=pictures, **values)


def _pictures(scenery: Scenery, numbered: Mapping[int, Finding], room: int) -> dict[int, Picture]:
    """Return the pictures of findings in about ``room`` bytes: what one spares, the next may take."""
    left = min(room, _PICTURES)
    pictures: dict[int, Picture] = {}
    for done, (number, finding) in enumerate(numbered.items()):
        made = finding_picture(scenery, finding, max(int(_GENEROUS * left / (len(numbered) - done)), 0))
        if made is not None and len(made.source) <= left:
            pictures[number] = made
            left -= len(made.source)
    return pictures


def _with_parts(numbered: Mapping[int, Finding]) -> frozenset[int]:
    """Return the numbers of the findings that get a part: every check its turn, failures first."""
    turns: dict[str, int] = {}
    ranked = []
    for number, finding in sorted(
        numbered.items(), key=lambda item: (item[1].status is not Status.FAIL, item[0])
    ):
        turns[finding.check] = turns.get(finding.check, 0) + 1
        ranked.append((turns[finding.check], number))
    return frozenset(number for _, number in sorted(ranked)[:_MOST_PARTS])


def _left_out(count: int, shown: int) -> str:
    if shown == count:
        return ""
    return (
        f"{shown} of {count} findings have a part of their own, of each check the first; the others stand in "
        "the tables, on the map and in the 3D view."
    )


def _checks(examination: Examination) -> list[dict[str, Any]]:
    """Return a row for each check, in the order of the findings."""
    known = known_checks()
    rows = []
    for check, status in statuses(examination.result).items():
        own = examination.result.of(check)
        reason = " ".join(dict.fromkeys(f.message for f in own if f.status is Status.SKIPPED))
        rows.append(
            {
                "id": check,
                "anchor": f"check-{check}",
                "status": str(status),
                "findings": counts(own),
                "sentence": known[check].sentence if check in known else "",
                "reason": told(reason),
            }
        )
    return rows


def _map(scenery: Scenery, numbered: Mapping[int, Finding], shown: frozenset[int]) -> Picture | None:
    made = overview(scenery, numbered, shown)
    if made is None:
        return None
    caption = "The model in plan."
    if numbered:
        which = "each finding" if len(shown) == len(numbered) else "each finding that has a part"
        caption = f"The model in plan; the worst place of {which} bears its number."
        nowhere = sum(not len(scenery.marks(f).everything) for f in numbered.values())
        caption += f" {plural(nowhere, 'finding')} without a place." if nowhere else ""
    caption += told(made.words())
    drawing = sum(len(s.surface.triangles) for s in scenery.faults.values()) <= _DRAWN
    alt = f"Map of {told(scenery.model.name)} with its faults, traces and {plural(len(numbered), 'finding')}."
    return picture(made.figure, alt, caption, _MAP, drawing)


def _about(scenery: Scenery, profile: str) -> list[tuple[str, str]]:
    """Return what the model is, key by key."""
    model = scenery.model
    ends = [scenery.frame.place(p, scenery.step) for p in model.bounds]
    triangles = [sum(len(s.triangles) for s in group) for group in (_of(model.horizons), _of(model.faults))]
    rows = [
        ("name", model.name),
        ("file", model.file.name if model.file else ""),
        ("horizons", str(len(model.horizons))),
        ("faults", str(len(model.faults))),
        ("triangles", f"{triangles[0]:,} of horizons, {triangles[1]:,} of faults"),
        ("z", f"{model.z}, positive {'up' if model.z_factor > 0 else 'down'}"),
        ("unit", model.unit),
        ("coordinate system", model.crs or "not given"),
        ("from", ends[0]),
        ("to", ends[1]),
        ("profile", profile),
    ]
    return [(key, told(value)) for key, value in rows if value]


def _of(items: Iterable[Any]) -> list[Surface]:
    return [item.surface for item in items]


def _tolerances(model: Model) -> list[tuple[str, str, str, str]]:
    """Return what each tolerance limits, its value and where that comes from."""
    rows = []
    for check in CHECKS:
        if check.tolerance is None:
            continue
        own = model.checks.get(check.id)
        values = check.tolerance.values(model) if own is None else [own]
        unit = check.tolerance.unit
        if unit == "model units":
            unit = "" if model.unit == "none" else model.unit
        said = [f"{value:.3g}" for value in (min(values, default=0.0), max(values, default=0.0))]
        origin = f"default: {check.tolerance.default}" if own is None else f"[checks] {check.id}"
        rows.append(
            (check.id, check.tolerance.meaning, f"{' to '.join(dict.fromkeys(said))} {unit}".rstrip(), origin)
        )
    return rows


def _surfaces(model: Model) -> list[tuple[str, str, str, str, str]]:
    kinds = [("horizon", s) for s in _of(model.horizons)] + [("fault", s) for s in _of(model.faults)]
    return [
        (
            told(s.name),
            kind,
            f"{len(s.vertices):,}",
            f"{len(s.triangles):,}",
            told(s.file.name) if s.file else "",
        )
        for kind, s in kinds
    ]
