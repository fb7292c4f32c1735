"""What all outputs of `graben check` say in the same words: the verdict, the counts, the places."""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from graben.finding import CheckResult, Finding, Part, Status
from graben.reports.style import Frame, placed, rounded
from graben.words import plural

if TYPE_CHECKING:
    from graben.model import Model

#: A place is told with the digits that matter for things this share of the model's size apart.
_SHARE = 0.01
#: Joins what is shown as one sign, as in many emoji.
_JOINER = "\u200d"
#: Characters that steer a terminal or the direction of writing, and halves of characters.
_UNSEEN = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})


def statuses(result: CheckResult) -> dict[str, Status]:
    """Return the gravest status of each check, by its id, in the order of the findings."""
    order = (Status.SKIPPED, Status.PASS, Status.WARN, Status.FAIL)
    found: dict[str, Status] = {}
    for finding in result.findings:
        known = found.get(finding.check, Status.SKIPPED)
        found[finding.check] = max(known, finding.status, key=order.index)
    return found


def verdict(result: CheckResult) -> str:
    """Return the verdict in one sentence, which begins with "PASSED" or "NOT PASSED".

    >>> from graben.finding import Profile
    >>> verdict(CheckResult(Profile.PAPER, (Finding("finite", Status.PASS), Finding("trace", Status.FAIL))))
    'NOT PASSED: 1 check fails (trace).'
    """
    status = statuses(result)
    failing, warning = ([c for c, s in status.items() if s is which] for which in (Status.FAIL, Status.WARN))
    said = [_listed(failing, "fail") if failing else "no check fails"]
    if warning:
        said.append(_listed(warning, "warn"))
    return f"{'PASSED' if result.passed else 'NOT PASSED'}: {', '.join(said)}."


def _listed(ids: list[str], verb: str) -> str:
    return f"{plural(len(ids), 'check')} {verb}{'s' if len(ids) == 1 else ''} ({', '.join(ids)})"


def counted(result: CheckResult) -> str:
    """Return how many checks passed, warn, fail and were skipped, and what the skipped ones wait for."""
    status = statuses(result)
    words = {Status.PASS: "passed", Status.WARN: "warn", Status.FAIL: "fail", Status.SKIPPED: "skipped"}
    numbers = ", ".join(f"{sum(s is key for s in status.values())} {word}" for key, word in words.items())
    waiting: dict[str, list[str]] = {}
    for finding in result.findings:
        if status[finding.check] is Status.SKIPPED:
            waiting.setdefault(finding.message.rstrip("."), []).append(finding.check)
    skipped = "; ".join(f"{', '.join(ids)} ({why})" for why, ids in waiting.items())
    return f"{plural(len(status), 'check')}: {numbers}{': ' if skipped else ''}{skipped}."


@dataclass(frozen=True)
class Teller:
    """Tells of places in the model's own convention of z; ``step`` is how far apart places are told apart."""

    frame: Frame
    step: float

    @classmethod
    def of(cls, model: Model) -> Teller:
        """Return the teller of a model."""
        return cls(Frame.of(model), _SHARE * model.size or 1.0)

    def place(self, place: Sequence[float]) -> str:
        """Return a place, x, y and elevation, in words.

        >>> Teller(Frame("m", -1.0), 10.0).place((1.0, 2.0, -1500.0))
        'x 1.0, y 2.0, depth 1500.0'
        """
        x, y, z = place
        frame = self.frame
        x_text, y_text, z_text = (placed(value, self.step) for value in (x, y, frame.z_factor * z + 0.0))
        return f"x {x_text}, y {y_text}, {frame.z_name} {z_text}"

    def worst(self, finding: Finding) -> str:
        """Return the worst value of a finding and its place: "gap, 3.5 m at x 1.0, y 2.0, depth 3.0"."""
        w = finding.worst
        if w is not None:
            value = f"{rounded(w.value)} {w.unit}".rstrip()
            return f"{measured_words(finding)}{value} at {self.place((w.x, w.y, w.z))}"
        return f"at {self.place(finding.places[0].tolist())}" if len(finding.places) else ""

    def part(self, part: Part) -> str:
        """Return one part of a finding in words."""
        size = "" if part.value is None else f", {rounded(part.value)} {part.unit}".rstrip()
        objects = f" of {', '.join(part.objects)}" if part.objects else ""
        return f"{part.kind}{objects} ({part.count}){size}, at {self.place(part.place)}"


def measured_words(finding: Finding) -> str:
    """Return what the worst value of a finding is the size of, with a comma; empty where no part has it."""
    w = finding.worst
    kinds = (p.kind for p in finding.parts if w is not None and (p.value, p.unit) == (w.value, w.unit))
    kind = next(kinds, "")
    return f"{kind}, " if kind else ""


def worst_words(finding: Finding, model: Model) -> str:
    """Return the worst value of one finding of a model and its place; see :meth:`Teller.worst`."""
    return Teller.of(model).worst(finding)


def seen(text: str) -> str:
    r"""Return text with every character that would steer a terminal written out.

    >>> print(seen("F\x1b[31m 1"))
    F\x1b[31m 1
    """
    return "".join(
        c.encode("unicode_escape").decode() if c != _JOINER and unicodedata.category(c) in _UNSEEN else c
        for c in text
    )
