"""What a change makes worse beside what it mends, told by the warnings before and after it."""

from __future__ import annotations

from collections.abc import Collection

from graben.finding import CheckResult, Finding, Status


def worsened(
    checks: Collection[str], names: Collection[str], before: CheckResult, after: CheckResult
) -> float:
    """Return by how much the findings about some surfaces grew, less what was mended of certain checks.

    A finding counts 1, and grows or shrinks by the share by which the elements it counts become more or
    fewer, at most 1. Findings of other checks that shrink mend nothing: no repair is done for what it does
    beside.

    Parameters
    ----------
    checks : collection of str
        Ids of the checks that the change answers.
    names : collection of str
        The surfaces that it changed, by their names before and after.
    before, after : CheckResult
        What the same checks say of the model without and with it.
    """
    counts = _counts(names, before), _counts(names, after)
    change = 0.0
    for check, objects in dict.fromkeys([*counts[0], *counts[1]]):
        was, now = (found.get((check, objects), 0) for found in counts)
        more = min(now / was - 1.0, 1.0) if was else 1.0
        change += more if check in checks else max(more, 0.0)
    return change


def grown(
    checks: Collection[str], names: Collection[str], before: CheckResult, after: CheckResult
) -> list[Finding]:
    """Return the findings about some surfaces that came or grew, but those of certain checks."""
    was = _counts(names, before)
    now = _counts(names, after)
    return [
        f
        for f in after.findings
        if f.check not in checks and now.get((f.check, f.objects), 0) > was.get((f.check, f.objects), 0)
    ]


def _counts(names: Collection[str], result: CheckResult) -> dict[tuple[str, tuple[str, ...]], int]:
    """Return how many elements each finding about one of some surfaces counts, at least 1."""
    return {
        (f.check, f.objects): max(f.count, 1)
        for f in result.findings
        if f.status in (Status.WARN, Status.FAIL) and set(names).intersection(f.objects)
    }
