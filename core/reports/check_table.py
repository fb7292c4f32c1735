"""The findings of `graben check` as a table for a terminal."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table
from rich.text import Text

from graben.finding import Finding, Status
from graben.reports.check_words import Teller, counted, seen, verdict

if TYPE_CHECKING:
    from graben.pipeline import Examination

#: Columns when nothing says how wide the reader's screen is: no line is broken, so that grep finds sentences.
_UNBROKEN = 100_000
#: So many findings of a check are shown, and so many parts of a finding.
_MOST = 20
#: Most columns for names, longer ones are folded; on a terminal this share of its width, if that is less.
_WIDEST, _SHARE = 80, 1 / 6
_STYLES = {Status.FAIL: "bold red", Status.WARN: "yellow", Status.PASS: "green", Status.SKIPPED: "dim"}


def check_table(examination: Examination, *, verbose: bool = False, console: Console | None = None) -> str:
    """Return the verdict, a table of what fails and warns, and a line that counts the checks.

    Parameters
    ----------
    examination : Examination
        Of :func:`graben.pipeline.examine`.
    verbose : bool
        List every finding, those that passed or were skipped as well, with its parts, and how long it took.
    console : rich.console.Console, optional
        Whose width and colours to use; without one the text is plain and its lines are not broken.

    Returns
    -------
    str
        Lines of text. Names are shown as they are, but for characters that would steer the terminal.
    """
    if console is None:
        console = Console(
            file=io.StringIO(), width=_UNBROKEN, force_terminal=False, force_jupyter=False, color_system=None
        )
    model, result = examination.model, examination.result
    with console.capture() as capture:
        colour = "bold green" if result.passed else "bold red"
        console.print(Text(verdict(result), style=colour), soft_wrap=False)
        about = f"Model {seen(model.name)}, profile {result.profile}."
        console.print(Text(about), soft_wrap=False)
        table, left = _table(examination, verbose, min(_WIDEST, int(_SHARE * console.width)))
        if table.row_count:
            console.print()
            console.print(table)
        for line in left:
            console.print(Text(line))
        console.print(Text(seen(counted(result))))
        if verbose:
            spent = f"{examination.seconds:.1f} s, largest memory {examination.peak_memory_mb:.0f} MiB."
            console.print(Text(spent))
    return "\n".join(line.rstrip() for line in capture.get().splitlines())


def _table(examination: Examination, verbose: bool, widest: int) -> tuple[Table, list[str]]:
    """Return the table, and a line for each check of which it leaves findings out."""
    table = Table(box=None, show_edge=False, pad_edge=False, padding=(0, 2, 1, 0))
    table.add_column("status", no_wrap=True)
    table.add_column("check", no_wrap=True)
    table.add_column("objects", overflow="fold", max_width=widest)
    table.add_column("count", justify="right", no_wrap=True)
    table.add_column("what, where, and what to do", overflow="fold")
    shown = (*_STYLES,) if verbose else (Status.FAIL, Status.WARN)
    left: list[str] = []
    teller = Teller.of(examination.model)
    for status in shown:
        by_check: dict[str, list[Finding]] = {}
        for finding in examination.result.findings:
            if finding.status is status:
                by_check.setdefault(finding.check, []).append(finding)
        for check, findings in by_check.items():
            listed = findings if verbose else findings[:_MOST]
            for finding in listed:
                table.add_row(*_row(finding, teller, verbose))
            if len(findings) > len(listed):
                left.append(
                    f"{len(findings) - len(listed)} more of {check} {status}: -v lists them, "
                    "and so does every file of findings."
                )
    return table, left


def _row(finding: Finding, teller: Teller, verbose: bool) -> Iterator[Text]:
    """Yield the cells of a row; none is markup, so that brackets stay what they are."""
    yield Text(str(finding.status), style=_STYLES[finding.status])
    yield Text(finding.check)
    yield Text(",\n".join(seen(name) for name in finding.objects))
    yield Text(str(finding.count or ""))
    lines = [Text(seen(finding.message))]
    where = teller.worst(finding)
    if where:
        lines.append(Text(f"Worst: {where}", style="cyan"))
    if verbose:
        lines += [Text(f"- {seen(teller.part(part))}") for part in finding.parts[:_MOST]]
        if len(finding.parts) > _MOST:
            lines.append(Text(f"- and {len(finding.parts) - _MOST} more"))
    if finding.remedy:
        lines.append(Text(f"To do: {seen(finding.remedy)}"))
    yield Text("\n").join(lines)
