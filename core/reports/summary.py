"""What a run and its horizons came to, in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from graben.finding import Status
from graben.modeling.results import HorizonResult, Subdomain, TerminationType
from graben.reports.style import Frame
from graben.words import plural

if TYPE_CHECKING:
    from graben.pipeline import RunResult

#: So many names are listed before "and more".
_MOST_NAMES = 3


def verdict(result: RunResult) -> str:
    """Return the verdict of a run as one sentence, which begins with "Modeled" or "NOT PASSED"."""
    cut = sum(bool(h.cutoffs) for h in result.horizons)
    every = len(result.model.horizons)
    if result.passed:
        plural = "" if every == 1 else "s"
        if cut == 0:
            return f"Modeled: no fault cuts {'the horizon' if every == 1 else f'any of {every} horizons'}."
        return f"Modeled: {cut} of {every} horizon{plural} cut by faults, all converged."
    reasons = []
    failing = list(dict.fromkeys(f.check for f in result.after.findings if f.status is Status.FAIL))
    if failing:
        reasons.append(f"{_counted(failing, 'check')} {'fails' if len(failing) == 1 else 'fail'}")
    open_ = [h.name for h in result.horizons if not h.converged]
    if open_:
        reasons.append(f"{_counted(open_, 'horizon')} did not converge everywhere")
    if result.not_modeled:
        missing = list(result.not_modeled)
        reasons.append(f"{_counted(missing, 'horizon')} {'was' if len(missing) == 1 else 'were'} not modeled")
    return f"NOT PASSED: {'; '.join(reasons) or 'the run did not finish'}."


def horizon_line(result: HorizonResult, frame: Frame) -> str:
    """Return how a horizon ended, in one line; a throw of a horizon that did not converge is marked."""
    if not result.cutoffs:
        return "not cut"
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


def _counted(names: Sequence[str], noun: str) -> str:
    more = len(names) - _MOST_NAMES
    listed = ", ".join(names[:_MOST_NAMES]) + (f" and {more} more" if more > 0 else "")
    return f"{plural(len(names), noun)} ({listed})"


def with_total(result: RunResult, seconds: float) -> RunResult:
    """Return a run whose timings count from the start of the command, ``seconds`` ago; "read" is the rest."""
    read = max(seconds - result.timings.get("total", 0.0), 0.0)
    return replace(result, timings={"read": read, **result.timings, "total": seconds})
