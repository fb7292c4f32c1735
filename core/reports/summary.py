"""What a run came to, in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from graben.finding import Status
from graben.modeling.results import HorizonResult, Subdomain, TerminationType
from graben.reports.style import Frame, rounded

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


def summary(result: RunResult, *, verbose: bool = False) -> str:
    """Return a run in a few lines of plain text for a terminal.

    Parameters
    ----------
    result : RunResult
        A finished run.
    verbose : bool
        Name every subdomain and the seconds of every stage as well.
    """
    frame = Frame.of(result.model)
    width = max((len(h.name) for h in result.model.horizons), default=0)
    lines = [verdict(result)]
    for h in result.horizons:
        lines.append(f"  {h.name:<{width}}  {horizon_line(h, frame)}")
        if verbose:
            lines += [f"  {'':<{width}}    {_subdomain_line(s)}" for s in h.subdomains if s.iterations]
    lines += [f"  {name:<{width}}  not modeled: {why}" for name, why in result.not_modeled.items()]
    for status in (Status.FAIL, Status.WARN):
        for f in result.after.findings:
            if f.status is status:
                lines.append(f"  {status}: {f.check}: {f.message} {f.remedy}".rstrip())
    lines += [f"  note: {h.name}: {warning}" for h in result.horizons for warning in h.warnings]
    if verbose:
        lines += [f"  {stage}: {seconds:.3f} s" for stage, seconds in result.timings.items()]
    if "total" in result.timings:
        lines.append(f"  {rounded(result.timings['total'])} s, {result.peak_memory_mb:.0f} MB")
    return "\n".join(lines)


def horizon_line(result: HorizonResult, frame: Frame) -> str:
    """Return how a horizon ended, in one line."""
    if not result.cutoffs:
        return "not cut"
    faults = plural(len({c.fault for c in result.cutoffs}), "fault")
    iterations = plural(max((s.iterations for s in result.subdomains), default=0), "iteration")
    course = f"{faults}, {iterations}, largest throw {frame.length(_throw(result))}"
    open_ = [s for s in result.subdomains if s.termination.type is not TerminationType.CONVERGED]
    if not open_:
        return f"{course}, converged"
    worst = max(open_, key=lambda s: s.termination.type).termination
    part = f"{len(open_)} of {plural(len(result.subdomains), 'subdomain')} not converged"
    return f"{course}, {part} (type {int(worst.type)}, {worst.name}): {worst.advice}".rstrip(" :")


def _subdomain_line(subdomain: Subdomain) -> str:
    t = subdomain.termination
    size = f"{plural(subdomain.unknowns, 'unknown')}, {plural(subdomain.iterations, 'iteration')}"
    return f"subdomain {subdomain.id} ({', '.join(subdomain.faults)}): {size}, type {int(t.type)}, {t.name}"


def _throw(result: HorizonResult) -> float:
    """Return the throw of largest magnitude with its sign, model units."""
    return float(max((t for c in result.cutoffs for t in c.throw), key=abs, default=0.0))


def _counted(names: Sequence[str], noun: str) -> str:
    more = len(names) - _MOST_NAMES
    listed = ", ".join(names[:_MOST_NAMES]) + (f" and {more} more" if more > 0 else "")
    return f"{plural(len(names), noun)} ({listed})"


def plural(count: int, noun: str) -> str:
    """Return a count with its noun.

    >>> plural(1, "fault"), plural(2, "fault")
    ('1 fault', '2 faults')
    """
    return f"{count} {noun}{'' if count == 1 else 's'}"
