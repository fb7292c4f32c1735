"""What a run and its horizons came to, in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from graben.finding import Status
from graben.modeling.results import HorizonResult, Side, Subdomain, TerminationType
from graben.reports.style import Frame
from graben.words import plural

if TYPE_CHECKING:
    from graben.pipeline import RunResult

#: So many names are listed before "and more".
_MOST_NAMES = 3
#: The two sides of a fault in words.
WALLS = {Side.HANGING: "hanging wall", Side.FOOT: "footwall"}


def verdict(result: RunResult) -> str:
    """Return the verdict of a run as one sentence, which begins with "Modeled" or "NOT PASSED"."""
    every = len(result.model.horizons)
    uncut = [h.name for h in result.horizons if h.converged and not h.cutoffs]
    passed_through = [_passed_through(uncut)] if uncut else []
    if result.passed:
        cut = sum(bool(h.cutoffs) for h in result.horizons)
        said = [f"{cut} of {plural(every, 'horizon')} cut by faults, all converged"] if cut else []
        return f"Modeled: {'; '.join([*said, *passed_through]) or 'the model has no horizon'}."
    reasons = []
    failing = list(dict.fromkeys(f.check for f in result.after.findings if f.status is Status.FAIL))
    if failing:
        verb = "fails" if len(failing) == 1 else "fail"
        reasons.append(f"{plural(len(failing), 'check')} ({_listed(failing)}) {verb}")
    open_ = [h.name for h in result.horizons if not h.converged]
    if open_:
        reasons.append(f"{_of(open_, every)} did not converge everywhere")
    if result.not_modeled:
        verb = "was" if len(result.not_modeled) == 1 else "were"
        reasons.append(f"{_of(list(result.not_modeled), every)} {verb} not modeled")
    return f"NOT PASSED: {'; '.join([*reasons, *passed_through]) or 'the run did not finish'}."


def _passed_through(names: Sequence[str]) -> str:
    """Return that no fault cuts these horizons, and what that means for them.

    >>> _passed_through(["Top A"])
    'no fault cuts Top A, which was passed through as it is'
    """
    if len(names) == 1:
        return f"no fault cuts {names[0]}, which was passed through as it is"
    few = f"{', '.join(names[:-1])} and {names[-1]}"
    said = few if len(names) <= _MOST_NAMES else _listed(names)
    return f"no fault cuts {said}, which were passed through as they are"


def horizon_line(result: HorizonResult, frame: Frame) -> str:
    """Return how a horizon ended, in one line; a throw of a horizon that did not converge is marked."""
    if not result.cutoffs and result.converged:
        return "no fault cuts it: passed through as it is"
    faults = plural(len({c.fault for c in result.cutoffs}), "fault")
    throw = f"{faults}, largest throw {frame.length(_throw(result))}"
    open_ = open_parts(result)
    if not open_:
        most = max((s.iterations for s in result.subdomains), default=0)
        return f"{throw}, converged in {plural(most, 'iteration')}"
    worst = max(open_, key=lambda s: s.termination.type)
    part = f"{len(open_)} of {plural(len(result.subdomains), 'subdomain')} did not converge"
    return f"{throw} (not final), {part}: {ended_words(worst)}"


def open_parts(result: HorizonResult) -> list[Subdomain]:
    """Return the subdomains of a horizon that ended otherwise than with type 0."""
    return [s for s in result.subdomains if s.termination.type is not TerminationType.CONVERGED]


def ended_words(subdomain: Subdomain) -> str:
    """Return how a subdomain ended, in plain words, with its type at the end.

    >>> from graben.modeling.results import Termination
    >>> t = Termination(TerminationType.PROJECTION_FAILURE, "projection failure", fault="F1")
    >>> ended_words(Subdomain(0, ("F1",), 9, 5, 3, t))
    'runs beyond the end of F1 (type 2)'
    """
    t = subdomain.termination
    fault = t.fault or "its faults"
    words = {
        TerminationType.CONVERGED: "converged",
        TerminationType.STAGNATION: f"does not come to rest at {fault}",
        TerminationType.PROJECTION_FAILURE: f"runs beyond the end of {fault}",
        TerminationType.VERTEX_REACHED: f"runs beyond the end of a rim or branch line of {fault}",
    }
    own = {"not anchored": "nothing holds it", "unstable": "its cuts lie too close to solve"}
    return f"{own.get(t.name, words[t.type])} (type {int(t.type)})"


def _throw(result: HorizonResult) -> float:
    """Return the throw of largest magnitude with its sign, model units."""
    return float(max((t for c in result.cutoffs for t in c.throw), key=abs, default=0.0))


def _of(names: Sequence[str], every: int) -> str:
    """Return how many horizons of all these are, and their names.

    >>> _of(["Top A"], 4)
    '1 of 4 horizons (Top A)'
    """
    return f"{len(names)} of {plural(every, 'horizon')} ({_listed(names)})"


def _listed(names: Sequence[str]) -> str:
    more = len(names) - _MOST_NAMES
    return ", ".join(names[:_MOST_NAMES]) + (f" and {more} more" if more > 0 else "")


def with_total(result: RunResult, seconds: float) -> RunResult:
    """Return a run whose timings count from the start of the command, ``seconds`` ago; "read" is the rest."""
    read = max(seconds - result.timings.get("total", 0.0), 0.0)
    return replace(result, timings={"read": read, **result.timings, "total": seconds})
