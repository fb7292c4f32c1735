"""The one-file report of a repair: verdict, what is left, each fault before and after, and each change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from graben.arrays import FloatArray
from graben.finding import Status
from graben.pipeline import Examination
from graben.reports.check_parts import MOST_ROWS, told
from graben.reports.check_view3d import view_space
from graben.reports.check_words import verdict as check_verdict
from graben.reports.fault_rows import fault_row, origin
from graben.reports.ledger_rows import checks_both, ledger, unseen
from graben.reports.page import Picture, rendered
from graben.reports.plain import named
from graben.reports.repair_blocks import BlocksMade, blocks_rows
from graben.reports.repair_figures import fault_picture
from graben.reports.repair_moves import FaultChange, fault_changes
from graben.reports.repair_scene import repair_scene
from graben.reports.repair_words import repair_verdict, warnings_words
from graben.reports.scenery import Scenery
from graben.reports.style import Frame, rounded
from graben.words import plural

if TYPE_CHECKING:
    from graben.repairs import RepairResult

#: Faults with a picture and a part of their own: those that changed most.
_MOST_PARTS = 40
#: Bytes of the page, with plotly.js (4.8 MB), and of all pictures.
_PAGE, _PICTURES = 9_700_000, 3_000_000
#: A picture may take so many times its even share of what is left.
_GENEROUS = 1.5
#: A view of a place spans this share of its fault to each side, or so many hundredths of the model.
_REACH, _AROUND = 0.15, 10.0


def repair_html(
    result: RepairResult,
    changes: Sequence[FaultChange] | None = None,
    *,
    files: bool = False,
    blocks: BlocksMade | None = None,
) -> str:
    """Return report.html of a repair as one page that works offline, on paper and in the dark.

    Parameters
    ----------
    result : RepairResult
        A finished repair.
    changes : sequence of FaultChange, optional
        Of :func:`graben.reports.repair_moves.fault_changes`.
    files : bool
        Whether model.toml and report.json stand beside the page, which then links to them.
    blocks : BlocksMade, optional
        The fault blocks, where they were asked for.

    Returns
    -------
    str
        The page, at most 10 MB. Only the seconds and the peak memory differ between two repairs of the same
        input.
    """
    return _Page(result, fault_changes(result) if changes is None else changes).text(files, blocks)


class _Page:
    """What the page is made of, each thing worked out once."""

    def __init__(self, result: RepairResult, changes: Sequence[FaultChange]) -> None:
        self.result = result
        self.left = (*result.left, *unseen(result.left, result.after))
        self.frame = Frame.of(result.input)
        self.step = result.input.size / 100.0 or 1.0
        seconds, memory = result.seconds, result.peak_memory_mb
        self.scenery = Scenery.of(Examination(result.model, result.after, {}, seconds, memory))
        self.changed = [c for c in changes if c.changed]
        self.same = [c for c in changes if not c.changed]
        ranked = sorted(self.changed, key=_weight, reverse=True)[:_MOST_PARTS]
        self.anchors = {c.name: f"fault-{k}" for k, c in enumerate(self.changed, start=1) if c in ranked}

    def text(self, files: bool, blocks: BlocksMade | None) -> str:
        """Return the page."""
        result = self.result
        rows = ledger(result.actions, self.left, result.after, self.frame, self.step)
        for row, note in zip(rows["left"], self.left, strict=False):
            place = None if note.place is None else np.array(note.place)
            row.update(self._spot(place, _AROUND * self.step))
        values: dict[str, Any] = {
            "title": told(result.input.name),
            "passed": result.passed,
            "verdict": told(repair_verdict(result)),
            "facts": told(self._facts()),
            **rows,
            "left_sentence": self._left_sentence(),
            "faults": [self._fault(c) for c in self.changed[:MOST_ROWS]],
            "faults_more": self._more(len(self.changed), MOST_ROWS),
            "unchanged": told(self._unchanged()),
            "parts": [self._part(c, rows["repairs"]) for c in self.changed if c.name in self.anchors],
            "parts_more": self._more(len(self.changed), len(self.anchors)),
            "before": told(check_verdict(result.before)),
            "after": told(check_verdict(result.after)),
            "checks": checks_both(result.before, result.after),
            "blocks": None if blocks is None else blocks_rows(blocks, result.model),
            "about": self._about(),
            "files": files,
            "seconds": f"{result.seconds:.2f}",
            "memory": f"{result.peak_memory_mb:.0f}",
        }
        found = {(f.check, f.objects): f for f in result.after.findings}
        numbered = {
            row["number"]: found[note.check, note.objects]
            for row, note in zip(rows["left"], self.left, strict=False)
            if (note.check, note.objects) in found
        }
        before = [c.given for c in self.changed if c.given is not None]
        scene = repair_scene(self.scenery, result.actions, numbered, before)
        bare = rendered("repair.html", scene, pictures={}, **values)
        pictures = self._pictures(_PAGE - len(bare.encode()))
        return rendered("repair.html", scene, pictures=pictures, **values)

    def _facts(self) -> str:
        model = self.result.input
        facts = [plural(len(model.horizons), "horizon"), plural(len(model.faults), "fault")]
        facts += [f"profile {self.result.after.profile}", f"unit {model.unit}", f"z is {model.z}"]
        return ", ".join([*facts, *([model.crs] if model.crs else [])])

    def _left_sentence(self) -> str:
        failing = sum(f.status is Status.FAIL for f in self.result.after.findings)
        warned = warnings_words(self.result)
        end = f" {warned}." if warned else ""
        if failing:
            verb = "keeps" if failing == 1 else "keep"
            said = f"{plural(failing, 'finding')} {verb} the model from passing"
            return f"{said}. Repair does not guess: here a person decides.{end}"
        return f"The model passes.{end}"

    def _more(self, count: int, shown: int) -> str:
        if count <= shown:
            return ""
        return f"{shown} of {count} changed faults are shown here; all are in report.json."

    def _unchanged(self) -> str:
        if not self.same:
            return ""
        verb = "is" if len(self.same) == 1 else "are"
        count = "Every fault" if not self.changed else plural(len(self.same), "fault")
        verb = "is" if not self.changed else verb
        return f"{count} {verb} as given, to the bit: {named([c.name for c in self.same])}."

    def _fault(self, change: FaultChange) -> dict[str, Any]:
        """Return the row of a fault with the anchor of its part."""
        row = fault_row(change, self.changed, self.frame)
        return {**row, "anchor": self.anchors.get(change.name, "")}

    def _part(self, change: FaultChange, rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        own = {n for n, _ in self._places(change)}
        reach = (
            _REACH * max(float(np.ptp(change.given.vertices, axis=0).max(initial=0.0)), self.step)
            if change.given
            else self.step
        )
        return {
            "name": told(change.name),
            "anchor": self.anchors[change.name],
            "origin": told(origin(change, self.changed)),
            "changes": [row for row in rows if row["number"] in own],
            **self._spot(change.largest_at, reach),
        }

    def _places(self, change: FaultChange) -> list[tuple[int, FloatArray | None]]:
        """Return the numbers of the changes that concern a fault, with their places."""
        names = {change.name, change.source}
        return [
            (number, None if a.place is None else np.array(a.place))
            for number, a in enumerate(self.result.actions, start=1)
            if names & {*a.objects, *(m.name for m in a.after if change.name == m.name)}
        ]

    def _spot(self, place: FloatArray | None, reach: float) -> dict[str, str]:
        """Return what the button that shows a place in 3D needs."""
        if place is None or not self.scenery.shapes:
            return {"spot": "", "reach": ""}
        local = view_space(self.scenery).local(place[None])[0]
        return {"spot": " ".join(f"{c:.9g}" for c in local), "reach": f"{reach:.6g}"}

    def _pictures(self, room: int) -> dict[str, Picture]:
        """Return the pictures of the faults by their anchors: what one spares, the next may take."""
        left = min(room, _PICTURES)
        pictures: dict[str, Picture] = {}
        shown = [c for c in self.changed if c.name in self.anchors]
        for done, change in enumerate(shown):
            places = [(n, p) for n, p in self._places(change) if p is not None]
            others = [s.surface for name, s in self.scenery.faults.items() if name != change.name]
            parts = [c.made for c in self.changed if c.source == change.source and c is not change and c.made]
            budget = max(int(_GENEROUS * left / (len(shown) - done)), 0)
            made = fault_picture(change, parts, others, places, self.frame, budget)
            if made is not None and len(made.source) <= left:
                pictures[self.anchors[change.name]] = made
                left -= len(made.source)
        return pictures

    def _about(self) -> list[tuple[str, str]]:
        """Return what the model is and how far repair might go, key by key."""
        model, settings = self.result.input, self.result.input.repair
        rows = [("name", model.name), ("file", model.file.name if model.file else "")]
        for key, limit in (("max_move", model.max_move), ("max_extension", model.max_extension)):
            values = [limit(f) for f in model.faults]
            said = dict.fromkeys(rounded(v) for v in (min(values, default=0.0), max(values, default=0.0)))
            given = "set in [repair]" if getattr(settings, key) is not None else "default"
            rows.append((key, f"{' to '.join(said)} {self.frame.unit}".rstrip() + f" ({given})"))
        rows += [
            (
                "dip_floor",
                f"{settings.dip_floor:g}°" + (", steepened to min_dip" if settings.steepen else ""),
            ),
            ("repairs switched off", ", ".join(settings.skip) or "none"),
            ("warnings", "repaired as well" if settings.warnings else "left alone"),
        ]
        rows += [("contact", f"{' and '.join(c.faults)}: {c.rule}") for c in model.contacts]
        return [(key, told(value)) for key, value in rows if value]


def _weight(change: FaultChange) -> tuple[float, float]:
    """Return how much a fault changed, to show those first that changed most."""
    return (max(change.largest_move, change.extended, change.cut_back), float(change.after is None))
