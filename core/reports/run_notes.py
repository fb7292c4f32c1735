"""What a person should look at in a finished run: numbered, with place and remedy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from graben.arrays import FloatArray, floats
from graben.finding import Finding, Status
from graben.modeling.quality import ThrowDoubt
from graben.modeling.results import HorizonResult, Subdomain, TerminationType
from graben.reports.check_parts import MOST_ROWS, sized, told
from graben.reports.check_words import measured_words
from graben.reports.marks import COLOURS
from graben.reports.plain import unsaid
from graben.reports.scene import Space
from graben.reports.shapes import drawable
from graben.reports.style import Frame
from graben.reports.summary import WALLS, ended_words
from graben.reports.view3d import Spot
from graben.words import plural

if TYPE_CHECKING:
    from graben.pipeline import RunResult

#: Kinds of marked places, as the switches of the 3D view name them.
TO_LOOK_AT, REPAIRS = "to look at", "repairs"
_CHANGED = "#1F5FA8"
#: The first warning of a kind stands before all others; these keep their order.
_TURNS = 2
#: So many notes are shown at once, whatever their kinds.
_FEW = 8


@dataclass(frozen=True, eq=False)
class Note:
    """Something to look at: how grave, of which kind, about what, what to do, and where (3,), if anywhere."""

    status: Status
    kind: str
    about: str
    words: str
    remedy: str = ""
    place: FloatArray | None = None
    detail: str = ""

    @property
    def parts(self) -> tuple[str, str]:
        """What it is about, to be set off, and the words after that; no name stands in both."""
        if self.words.startswith(f"{self.about} "):
            return self.about, self.words[len(self.about) :]
        head = "" if self.about and not unsaid([self.about], self.words) else self.about
        return (f"{head}.", f" {self.words}") if head else ("", self.words)


def notes(result: RunResult) -> list[Note]:
    """Return what a person should look at: failures, then the first warning of each kind, then the others."""
    frame = Frame.of(result.model)
    found = [Note(Status.FAIL, "", name, f"Not modeled: {why}") for name, why in result.not_modeled.items()]
    found += [note for h in result.horizons for note in _ended(h, frame)]
    for status in (Status.FAIL, Status.WARN):
        found += [_finding(f) for f in result.after.findings if f.status is status]
    found += [note for h in result.horizons for note in _warned(h)]
    turns: dict[str, int] = {}
    ranked = []
    for note in found:
        failing = note.status is Status.FAIL
        turns[note.kind] = turns.get(note.kind, 0) + (not failing)
        ranked.append((min(turns[note.kind], _TURNS) if not failing else 0, note))
    return [note for _, note in sorted(ranked, key=lambda pair: pair[0])]


def first_of_kinds(found: Sequence[Note]) -> int:
    """Return how many notes stand before the second of a kind, of :func:`notes`."""
    seen: set[str] = set()
    for k, note in enumerate(found):
        if note.status is not Status.FAIL and note.kind in seen:
            return k
        seen |= {note.kind} if note.status is not Status.FAIL else set()
    return len(found)


def _ended(horizon: HorizonResult, frame: Frame) -> Iterator[Note]:
    """Yield the subdomains that did not converge."""
    for s in horizon.subdomains:
        t = s.termination
        if t.type is TerminationType.CONVERGED:
            continue
        words = f"Subdomain {s.id}: {ended_words(s)}"
        words += f", in the {WALLS[t.side]}" if t.fault and t.side else ""
        words += f", short by {frame.length(t.short_by)}" if t.short_by is not None else ""
        yield Note(Status.FAIL, "", horizon.name, f"{words}.", t.advice, termination_place(s))


def termination_place(subdomain: Subdomain) -> FloatArray | None:
    """Return where a subdomain ended otherwise than with type 0, (3,), if that is known."""
    t = subdomain.termination
    return None if t.x is None or t.y is None or t.z is None else floats([t.x, t.y, t.z])


def _finding(finding: Finding) -> Note:
    place, detail = None, ""
    if finding.worst is not None:
        w = finding.worst
        place = floats([w.x, w.y, w.z])
        detail = f"worst: {measured_words(finding)}{sized(w.value, w.unit)}"
    elif len(finding.places):
        place = finding.places[0]
    names = finding.objects if unsaid(finding.objects, finding.message) else ()
    about = f"{finding.check}: {', '.join(names)}" if names else finding.check
    return Note(finding.status, finding.check, about, finding.message, finding.remedy, place, detail)


def _warned(horizon: HorizonResult) -> Iterator[Note]:
    """Yield the warnings of a horizon; those about throws have a place."""
    known = {str(d): d for d in horizon.doubts}
    for words in horizon.warnings:
        doubt = known.get(words)
        if doubt is None:
            said, remedy = parted(words)
            yield Note(Status.WARN, horizon.name, horizon.name, said, remedy)
        else:
            yield _doubt(doubt)


def parted(warning: str) -> tuple[str, str]:
    """Return what a warning of a horizon sees, and what it says is to be done, empty where it does not.

    >>> parted("The zone is narrow. To do: raise gamma.")
    ('The zone is narrow.', 'Raise gamma.')
    """
    words, _, remedy = warning.partition(" To do: ")
    return words, remedy[:1].upper() + remedy[1:]


def _doubt(doubt: ThrowDoubt) -> Note:
    """Return a doubt about a throw, its sentence parted into what is seen and what to do."""
    said, _, remedy = doubt.message.rpartition(": ")
    remedy = remedy.partition(" (at ")[0]
    words, remedy = (f"{said}.", f"{remedy[:1].upper()}{remedy[1:]}.") if said else (doubt.message, "")
    return Note(Status.WARN, f"throw: {doubt.kind}", doubt.horizon, words, remedy, doubt.place)


def note_rows(found: Sequence[Note], space: Space | None, frame: Frame, step: float) -> dict[str, Any]:
    """Return the rows of the table, numbered from 1, and what was left out of it.

    Parameters
    ----------
    found : sequence of Note
        Of :func:`notes`.
    space : Space or None
        Coordinates of the 3D view; None where there is none.
    frame : Frame
        Unit and sign of z.
    step : float
        What tells how many digits of a coordinate matter, model units.
    """
    rows = []
    for number, note in enumerate(found[:MOST_ROWS], start=1):
        at = note.place if note.place is not None and drawable(note.place) else None
        said = "" if at is None else frame.place(at, step)
        about, words = note.parts
        rows.append(
            {
                "number": number,
                "anchor": f"note-{number}",
                "status": str(note.status),
                "about": told(about),
                "words": told(words),
                "remedy": told(note.remedy),
                "where": "; ".join(part for part in (note.detail, said) if part),
                **spot(at, space, step),
            }
        )
    more, first = len(found) - len(rows), first_of_kinds(found)
    first = len(rows) if len(rows) <= _FEW else first
    return {
        "notes": rows[:first],
        "notes_rest": rows[first:],
        "notes_more": f"{plural(more, 'more')}: all are in report.json." if more > 0 else "",
    }


def spot(place: FloatArray | None, space: Space | None, step: float) -> dict[str, str]:
    """Return what the button that shows a place in 3D needs."""
    if place is None or space is None:
        return {"spot": "", "reach": ""}
    local = space.local(place[None])[0]
    return {"spot": " ".join(f"{c:.9g}" for c in local), "reach": f"{_STEPS * step:.6g}"}


#: A view of a place shows so many steps of the horizon around it.
_STEPS = 12.0


def spots(result: RunResult, found: Sequence[Note]) -> list[Spot]:
    """Return the places that the 3D view marks: of notes and of repairs, by the numbers of the tables."""
    marked = [
        Spot(TO_LOOK_AT, number, "".join(note.parts), note.place, COLOURS[note.status])
        for number, note in enumerate(found[:MOST_ROWS], start=1)
        if note.place is not None and drawable(note.place)
    ]
    for number, action in enumerate(result.repairs[:MOST_ROWS], start=1):
        if action.place is not None and drawable(np.array(action.place)):
            words = f"{action.action}: {action.reason}"
            marked.append(Spot(REPAIRS, number, words, floats(action.place), _CHANGED))
    return marked
