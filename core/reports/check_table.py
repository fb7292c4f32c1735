"""The findings of `graben check` as text for a terminal, a mail or a search."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from graben.finding import Finding, Status
from graben.reports.check_words import Teller, counted, seen, verdict
from graben.reports.plain import LINE, UNBROKEN, about, fitted, folded, more, named
from graben.words import plural

if TYPE_CHECKING:
    from rich.console import Console

    from graben.pipeline import Examination

#: So many parts of a finding are listed.
_MOST_PARTS = 20
_SAID = (Status.FAIL, Status.WARN)
_STYLES = {Status.FAIL: "bold red", Status.WARN: "yellow", Status.PASS: "green", Status.SKIPPED: "dim"}


def check_table(
    examination: Examination,
    *,
    verbose: bool = False,
    console: Console | None = None,
    seconds: float | None = None,
) -> str:
    """Return the verdict, each check that fails or warns with its findings, and how many checks there were.

    The lines fit a mail, or the console where it is narrower. Of many findings as many are shown as fit a
    page: at least one of each check that fails, and of one that warns the names.

    Parameters
    ----------
    examination : Examination
        Of :func:`graben.pipeline.examine`.
    verbose : bool
        List every finding, those that passed or were skipped as well, with its parts, and how long it took;
        without a console no line is broken.
    console : rich.console.Console, optional
        Whose width and colours to use; without one the text is plain.
    seconds : float, optional
        How long it took from the start of the command; default how long the checks took.

    Returns
    -------
    str
        Lines of text. Names are shown as they are, but for characters that would steer the terminal.
    """
    width = min(LINE, console.width) if console is not None else (UNBROKEN if verbose else LINE)
    result = examination.result
    made = _Lines(Teller.of(examination.model), width, verbose)
    head = folded(verdict(result), width=width)
    head += folded(f"Model {seen(examination.model.name)}, profile {result.profile}.", width=width)
    tail = folded(seen(counted(result)), width=width)
    mended = dict.fromkeys(f.check for f in result.findings if f.repairable and f.status in _SAID)
    if mended:
        tail += folded(f"graben repair may mend: {', '.join(mended)}.", width=width)
    if verbose:
        spent = examination.seconds if seconds is None else seconds
        tail.append(f"{spent:.1f} s, largest memory {examination.peak_memory_mb:.0f} MiB.")

    def whole(most: int | None) -> list[str]:
        body = made.of(result.findings, most)
        return [*head, *body, *([""] if body else []), *tail]

    lines = whole(None) if verbose else fitted(whole)
    colour = "bold green" if result.passed else "bold red"
    return lines_text(lines, console, {**dict.fromkeys(head[:1], colour), **made.styles})


def lines_text(lines: Sequence[str], console: Console | None, styles: dict[str, str]) -> str:
    """Return lines as one text, with the colours of a console where there is one."""
    if console is None:
        return "\n".join(lines)
    from rich.text import Text

    with console.capture() as capture:
        for line in lines:
            console.print(Text(line, style=styles.get(line, "")), soft_wrap=True)
    return capture.get().rstrip("\n")


class _Lines:
    """Makes the lines of findings; ``styles`` are the colours of those lines that have one."""

    def __init__(self, teller: Teller, width: int, verbose: bool) -> None:
        self.styles: dict[str, str] = {}
        self._teller, self._width, self._verbose = teller, width, verbose

    def of(self, findings: Sequence[Finding], most: int | None) -> list[str]:
        """Return a block for each check that has something to say, with at most so many of its findings."""
        lines: list[str] = []
        for status in (*_STYLES,) if self._verbose else _SAID:
            said = [f for f in findings if f.status is status]
            for check in dict.fromkeys(f.check for f in said):
                lines += self._block(status, check, [f for f in said if f.check == check], most)
        return lines

    def _block(self, status: Status, check: str, findings: list[Finding], most: int | None) -> list[str]:
        found = status in _SAID
        head = f"{status:<7} {check}" + (f", {plural(len(findings), 'finding')}" if found else "")
        if most == 0 and status is Status.WARN:
            return self._named(head, status, findings)
        shown = findings if most is None else findings[: max(most, 1)]
        self.styles[head] = _STYLES[status]
        lines = ["", head]
        for k, finding in enumerate(shown):
            lines += (line for text in self._said(finding) for line in folded(text, "  ", self._width))
            # What is to be done for several alike is said once, after the last of them.
            if finding.remedy and finding.remedy not in (f.remedy for f in shown[k + 1 :]):
                lines += folded(f"To do: {seen(finding.remedy)}", "  ", self._width)
        left = dict.fromkeys(seen(name) for f in findings[len(shown) :] for name in f.objects)
        return lines + more(len(findings), len(shown), "  ", list(left), self._width)

    def _named(self, head: str, status: Status, findings: list[Finding]) -> list[str]:
        """Return what warns with the names that it is about alone, and the first remedy."""
        names = dict.fromkeys(seen(name) for f in findings for name in f.objects)
        lines = folded(f"{head}: {named(list(names))}" if names else head, width=self._width)
        self.styles.update(dict.fromkeys(lines, _STYLES[status]))
        remedies = dict.fromkeys(seen(f.remedy) for f in findings if f.remedy)
        return [*lines, *(line for r in [*remedies][:1] for line in folded(f"To do: {r}", "  ", self._width))]

    def _said(self, finding: Finding) -> Iterator[str]:
        """Yield a finding, its worst value and, where all is to be told, its parts."""
        yield about((seen(name) for name in finding.objects), seen(finding.message))
        where = self._teller.worst(finding)
        if where:
            yield f"Worst: {where}"
        if self._verbose:
            yield from (f"- {seen(self._teller.part(part))}" for part in finding.parts[:_MOST_PARTS])
            if len(finding.parts) > _MOST_PARTS:
                yield f"- and {len(finding.parts) - _MOST_PARTS} more"
