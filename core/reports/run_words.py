"""What a run came to, in lines of plain text for a terminal or a mail."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from graben.finding import Status
from graben.reports.check_words import seen
from graben.reports.plain import LINE, about, counts, fitted, folded, more, named, unsaid
from graben.reports.run_notes import parted
from graben.reports.run_rows import sizes
from graben.reports.style import Frame, rounded
from graben.reports.summary import horizon_line, open_parts, verdict
from graben.words import plural

if TYPE_CHECKING:
    from graben.modeling.results import HorizonResult, Subdomain
    from graben.pipeline import RunResult

#: A column of names is no wider than this.
_WIDEST = 24


def run_summary(result: RunResult, *, verbose: bool = False, seconds: float | None = None) -> str:
    """Return a run in a few lines: the verdict, each horizon, what is to be looked at and to be done.

    Parameters
    ----------
    result : RunResult
        A finished run.
    verbose : bool
        List everything: findings, notes, subdomains and the seconds of every stage, each in one line.
    seconds : float, optional
        How long it took from the start of the command; default the total of the timings.
    """
    spent = result.timings.get("total") if seconds is None else seconds
    head = [verdict(result), _model(result, spent)]
    if verbose:
        return "\n".join(map(seen, [*head, *_everything(result)]))
    return "\n".join(fitted(lambda most: _short(result, head, most)))


def _model(result: RunResult, seconds: float | None) -> str:
    model = result.model
    spent = "" if seconds is None else f"; {rounded(seconds)} s, {result.peak_memory_mb:.0f} MB"
    return f"Model {model.name}: {sizes(result)}, profile {result.after.profile}{spent}."


def _short(result: RunResult, head: list[str], most: int) -> list[str]:
    """Return the summary with at most so many things of a kind, but one at least; no line too long."""
    most = max(most, 1)
    lines = [line for text in head for line in folded(seen(text))]
    shown = _horizons(result)
    lines += ["", *(line for text in shown[:most] for line in folded(seen(text), "  "))]
    lines += more(len(shown), most, "  ")
    told = list(_counted(result))
    lines += ["", *(line for text in told for line in folded(text))] if told else []
    todo = list(dict.fromkeys(_todo(result)))
    if todo:
        lines += ["", "To do", *(line for text in todo[:most] for line in folded(seen(f"- {text}"), "  "))]
        lines += more(len(todo), most, "  ")
    return lines


def _horizons(result: RunResult) -> list[str]:
    """Return a line for each horizon, those first that are not as they should be."""
    frame = Frame.of(result.model)
    width = min(max((len(h.name) for h in result.model.horizons), default=0), _WIDEST)
    lines = []
    for name, why in result.not_modeled.items():
        room = LINE - width - len("  not modeled: ") - 4
        lines.append(f"{name:<{width}}  not modeled: {why if len(why) <= room else why[: room - 3] + '...'}")
    for converged in (False, True):
        found = (h for h in result.horizons if h.converged is converged)
        lines += [f"{h.name:<{width}}  {horizon_line(h, frame)}" for h in found]
    return lines


def _counted(result: RunResult) -> Iterator[str]:
    """Yield how much was repaired, and how many findings and notes there are of each kind."""
    if result.repairs or result.left:
        left = f"; {plural(len(result.left), 'finding')} looked at and left" if result.left else ""
        done = counts(a.action for a in result.repairs)
        yield f"Repaired: {done or 'nothing'}{left}."
    findings = result.after.findings
    notes = sum(len(h.warnings) for h in result.horizons)
    for status, word in ((Status.FAIL, "Fails"), (Status.WARN, "Warns")):
        said = [counts(f.check for f in findings if f.status is status)]
        said += [f"notes on horizons {notes}"] if status is Status.WARN and notes else []
        if any(said):
            yield f"{word} (see report): {', '.join(s for s in said if s)}."


def _todo(result: RunResult) -> Iterator[str]:
    """Yield what to do: where a horizon is open, then what fails, what warns, and what notes say."""
    for h in result.horizons:
        yield from (about([h.name], s.termination.advice) for s in open_parts(h) if s.termination.advice)
    for status in (Status.FAIL, Status.WARN):
        alike: dict[tuple[str, str], list[str]] = {}
        for f in result.after.findings:
            if f.status is status and f.remedy:
                alike.setdefault((f.check, f.remedy), []).extend(f.objects)
        for (check, remedy), names in alike.items():
            missing = unsaid(dict.fromkeys(names), remedy)
            yield f"{check}, {named(missing)}: {remedy}" if missing else f"{check}: {remedy}"
    for h in result.horizons:
        yield from (about([h.name], remedy) for _, remedy in map(parted, h.warnings) if remedy)


def _everything(result: RunResult) -> Iterator[str]:
    """Yield every horizon with its subdomains, every finding and note, and the seconds of every stage."""
    frame = Frame.of(result.model)
    for h in result.horizons:
        yield f"  {h.name}: {horizon_line(h, frame)}"
        yield from (f"    {_subdomain(s)}" for s in h.subdomains if s.iterations or s in open_parts(h))
    for name, why in result.not_modeled.items():
        yield f"  {name}: not modeled: {why}"
    for status in (Status.FAIL, Status.WARN):
        for f in result.after.findings:
            if f.status is status:
                yield f"  {status}: {f.check}: {about(f.objects, f.message)} {f.remedy}".rstrip()
    yield from (f"  note: {words}" for h in result.horizons for words in _notes(h))
    yield from (f"  {stage}: {seconds:.3f} s" for stage, seconds in result.timings.items())


def _notes(horizon: HorizonResult) -> Iterator[str]:
    return (about([horizon.name], warning) for warning in horizon.warnings)


def _subdomain(subdomain: Subdomain) -> str:
    t = subdomain.termination
    size = f"{plural(subdomain.unknowns, 'unknown')}, {plural(subdomain.iterations, 'iteration')}"
    told = f"subdomain {subdomain.id} ({', '.join(subdomain.faults)}): {size}, type {int(t.type)}, {t.name}"
    return f"{told}: {t.advice}" if t.advice else told
