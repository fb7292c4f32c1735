"""report.html: one file that works offline, on paper, in the dark and by keyboard."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from graben.modeling.results import HorizonResult
from graben.modeling.throws import FaultThrow, fault_throws
from graben.reports.check_parts import MOST_ROWS, told
from graben.reports.check_words import verdict as check_verdict
from graben.reports.fault_rows import fault_row, run_changes
from graben.reports.json_report import Files
from graben.reports.ledger_rows import checks_both, ledger
from graben.reports.model_files import ModelFiles
from graben.reports.page import rendered
from graben.reports.repair_words import left_sentence
from graben.reports.run_figures import RunFigures, Truth
from graben.reports.run_notes import Note, note_rows, notes, spots
from graben.reports.run_rows import (
    facts,
    key_figures,
    parameters,
    products,
    score_rows,
    settings,
    subdomain_rows,
    throw_row,
)
from graben.reports.scene import Scene
from graben.reports.style import Frame, rounded
from graben.reports.summary import horizon_line, open_parts, verdict
from graben.reports.view3d import run_space, scene
from graben.words import plural

if TYPE_CHECKING:
    from graben.pipeline import RunResult
    from graben.reports.repair_moves import FaultChange

__all__ = ["Seen", "Truth", "report_html", "run_seen"]

#: Bytes of the page, with plotly.js (4.8 MB), and of all pictures.
_PAGE, _PICTURES = 9_700_000, 3_000_000


@dataclass(frozen=True, eq=False)
class Seen:
    """What takes long of a report besides the pictures: the faults that changed, the notes, the 3D view."""

    changed: list[FaultChange]
    notes: list[Note]
    view: Scene | None


def run_seen(result: RunResult) -> Seen:
    """Return the changed faults, the notes and the 3D view of a run."""
    changed = [c for c in run_changes(result) if c.changed] if result.repairs else []
    found = notes(result)
    return Seen(changed, found, scene(result, {c.name: c.moves for c in changed}, spots(result, found)))


def report_html(
    result: RunResult,
    files: Files,
    truth: Truth | None = None,
    whole: ModelFiles | None = None,
    tables: Sequence[str] = (),
    seen: Seen | None = None,
    made: str = "",
) -> str:
    """Return report.html of a run.

    Parameters
    ----------
    result : RunResult
        A finished run.
    files : mapping of str to mapping of str to str
        For each horizon the files written for it: what the file is -> path relative to the report.
    truth : mapping of str to sequence of (k,) arrays, optional
        For a horizon the true throws at the rows of its cutoffs.
    whole : ModelFiles, optional
        The files written for the whole model, and why others were not.
    tables : sequence of str, optional
        Names of the tables written.
    seen : Seen, optional
        What :func:`run_seen` has made of it already.
    made : str
        When, if the page shall say so; it stands with the timings.

    Returns
    -------
    str
        The page, at most 10 MB. Only the timings and the peak memory differ between two runs on the same
        input.
    """
    frame = Frame.of(result.model)
    surfaces = [f.surface for f in result.repaired.faults]
    throws = [
        t for h in result.horizons if h.cutoffs for t in fault_throws(h, surfaces, result.model.tolerance)
    ]
    step = max((h.step for h in result.model.horizons), default=result.model.size / 100.0 or 1.0)
    seen = seen or run_seen(result)
    changed, found, view = seen.changed, seen.notes, seen.view
    space = run_space(result)
    values: dict[str, Any] = {
        "title": told(result.model.name),
        "passed": result.passed,
        "verdict": told(verdict(result)),
        "facts": told(facts(result)),
        "unit": f" [{frame.unit}]" if frame.unit else "",
        "key_figures": key_figures(result, throws, changed, frame),
        **note_rows(found, space, frame, step),
        "horizons": [_horizon(result, h, k, frame) for k, h in enumerate(result.horizons, start=1)],
        "not_modeled": [(told(name), told(why)) for name, why in result.not_modeled.items()],
        **_faults(result, throws, frame),
        **subdomain_rows(result, space, frame),
        "scores": score_rows(result),
        "before": told(check_verdict(result.before)),
        "after": told(check_verdict(result.after)),
        "checks": checks_both(result.before, result.after),
        **ledger(result.repairs, result.left, result.after, frame, step),
        "changed": [fault_row(c, changed, frame) for c in changed[:MOST_ROWS]],
        "changed_more": _more(len(changed), "changed fault"),
        **products(result, files, whole or ModelFiles(), tables),
        "left_sentence": left_sentence(result),
        "parameters": parameters(result, frame),
        "timings": [(stage.replace("_", " "), rounded(s)) for stage, s in result.timings.items()],
        "made": made,
        "memory": f"{result.peak_memory_mb:.0f}",
    }
    empty: dict[str, Any] = {"maps": {}, "horizons": {}, "faults": {}, "stereonet": None, "convergence": None}
    bare = rendered("report.html", view, pictures=empty, **values)
    room = min(_PAGE - len(bare.encode()), _PICTURES)
    pictures = RunFigures(result, frame, truth or {}, throws, room).all()
    return rendered("report.html", view, pictures=pictures, **values)


def _horizon(run: RunResult, result: HorizonResult, number: int, frame: Frame) -> dict[str, Any]:
    cut = dict.fromkeys(c.fault for c in result.cutoffs)
    return {
        "key": result.name,
        "name": told(result.name),
        "anchor": f"horizon-{number}",
        "map": f"map-{number}",
        "line": told(horizon_line(result, frame)),
        "converged": result.converged,
        "faults": told(", ".join(cut)) or "none",
        "nodes": f"{len(result.surface.vertices):,}",
        "throw": frame.length(result.largest_throw) if cut else "",
        "notes": [told(settings(run, result, frame)), *map(told, result.horizon.notes)],
        "chosen": result is max(run.horizons, key=lambda h: h.largest_throw),
    }


def _faults(result: RunResult, throws: Sequence[FaultThrow], frame: Frame) -> dict[str, Any]:
    """Return the faults that cut a horizon, that of the largest throw first, with a row for each horizon."""
    largest: dict[str, float] = {}
    for t in throws:
        largest[t.fault] = max(largest.get(t.fault, 0.0), abs(t.throw))
    names = sorted(largest, key=lambda name: -largest[name])
    open_ = {(h.name, name) for h in result.horizons for s in open_parts(h) for name in s.faults}
    rows = [
        {
            "key": name,
            "name": told(name),
            "throw": frame.length(largest[name]),
            "rows": [
                throw_row(t, frame, final=(t.horizon, name) not in open_) for t in throws if t.fault == name
            ],
        }
        for name in names[:MOST_ROWS]
    ]
    uncut = [f.name for f in result.repaired.faults if f.name not in largest]
    said = f"Without a cutoff: {told(', '.join(uncut))}." if uncut else ""
    return {"faults": rows, "faults_more": _more(len(names), "fault"), "uncut": said}


def _more(count: int, noun: str) -> str:
    more = count - MOST_ROWS
    return f"{plural(more, f'more {noun}')}: all are in report.json." if more > 0 else ""
