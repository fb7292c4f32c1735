"""The ledger as pages show it: a row for each change, and one for whatever is left."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from graben.cleaning.ledger import Left, left_over
from graben.finding import Status
from graben.reports.check_parts import MOST_ROWS, counts, known_checks, sized, told
from graben.reports.check_words import statuses
from graben.reports.plain import named
from graben.reports.repair_words import TABLE_4, move_words, needed_words
from graben.reports.style import Frame
from graben.words import plural

if TYPE_CHECKING:
    from graben.cleaning.ledger import RepairAction
    from graben.finding import CheckResult, Finding


def ledger(
    actions: Sequence[RepairAction], left: Sequence[Left], after: CheckResult, frame: Frame, step: float
) -> dict[str, Any]:
    """Return the rows of both tables, numbered from 1, and what was left out of them, as plain text.

    Parameters
    ----------
    actions, left : sequences
        Of the result of a repair or a run.
    after : CheckResult
        The findings that are left.
    frame : Frame
        Unit and sign of z.
    step : float
        What tells how many digits of a coordinate matter, model units.
    """
    found = {(f.check, f.objects): f for f in after.findings}
    return {
        "repairs": [_change(n, a, frame, step) for n, a in enumerate(actions[:MOST_ROWS], start=1)],
        "repairs_more": _more(len(actions), "change"),
        "left": [
            _left(n, a, found.get((a.check, a.objects)), frame, step)
            for n, a in enumerate(left[:MOST_ROWS], start=1)
        ],
        "left_more": _more(len(left), "entry").replace("entrys", "entries"),
    }


def unseen(left: Sequence[Left], after: CheckResult) -> tuple[Left, ...]:
    """Return the warnings after a repair that it did not look at, as notes of what is left."""
    known = {(note.check, note.objects) for note in left}
    why = "It only warns, and no repair looked at it."
    notes = (
        Left(f.check, f.objects, "", None, why, "")
        for f in after.findings
        if f.status is Status.WARN and (f.check, f.objects) not in known
    )
    return left_over(after, notes, {})[len(left_over(after, (), {})) :]


def _more(count: int, noun: str) -> str:
    more = count - MOST_ROWS
    return f"{plural(more, f'more {noun}')}: all are in report.json." if more > 0 else ""


def _change(number: int, action: RepairAction, frame: Frame, step: float) -> dict[str, Any]:
    return {
        "number": number,
        "anchor": f"change-{number}",
        "action": action.action,
        "check": action.check,
        "objects": told(named(action.objects)),
        "count": f"{action.count:,}",
        "move": move_words(action.max_move, frame, step) or "–",
        "size": sized(action.size, action.unit),
        "place": "" if action.place is None else frame.place(action.place, step),
        "reason": told(action.reason),
    }


def _left(number: int, left: Left, finding: Finding | None, frame: Frame, step: float) -> dict[str, Any]:
    """Return the row of what is left; ``spot`` and ``reach`` are for pages that show the place in 3D."""
    return {
        "status": str(finding.status) if finding else "",
        "message": told(finding.message) if finding else "",
        "spot": "",
        "reach": "",
        "number": number,
        "anchor": f"left-{number}",
        "check": left.check,
        "objects": told(named(left.objects)) or "the model",
        "action": left.action,
        "place": "" if left.place is None else frame.place(left.place, step),
        "reason": told(left.reason),
        "needed": needed_words(left),
        "advice": told(left.advice),
        "modeling": TABLE_4.get(left.check, ""),
    }


def checks_both(before: CheckResult, after: CheckResult) -> list[dict[str, str]]:
    """Return a row for each check: its status and findings before and after a repair."""
    known, sides = known_checks(), (statuses(before), statuses(after))
    rows = []
    for check in dict.fromkeys([*sides[0], *sides[1]]):
        rows.append(
            {
                "id": check,
                "before": str(sides[0].get(check, Status.SKIPPED)),
                "after": str(sides[1].get(check, Status.SKIPPED)),
                "before_count": counts(before.of(check)),
                "after_count": counts(after.of(check)),
                "sentence": known[check].sentence if check in known else "",
            }
        )
    return rows
