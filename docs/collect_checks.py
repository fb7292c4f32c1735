"""Put what the registries say of checks and repairs into their pages: `python docs/collect_checks.py`.

The parts between the two marks are written anew, all else stays; a test holds the pages to the registry.
"""

from __future__ import annotations

import sys
from pathlib import Path

from between_marks import write

from graben.cleaning.registry import REPAIRS
from graben.validators.context import Check, Need, Scope, Severity
from graben.validators.registry import CHECKS

DOCS = Path(__file__).resolve().parent
WAITS = {
    Need.SURFACES: "coordinates that are numbers",
    Need.COMPLEX: "faults without a blocking failure, refined to one complex",
    Need.GRAPH: "the traces of the faults on the horizon",
    Need.ANCHORS: "the horizon cut into subdomains",
}
PROFILES = {
    Severity.FAIL: ("fail", "fail"),
    Severity.RELAXED: ("fail", "warn"),
    Severity.WARN: ("warn", "warn"),
}


def facts(check: Check) -> str:
    """Return the facts of one check as a table for its page."""
    paper, extended = PROFILES[check.severity]
    rows = {
        "Asks": check.sentence,
        "Why": check.why,
        "Paper": f"section {check.section}",
        "Profile paper, extended": f"{paper}, {extended}" + (f"; {check.leniency}" if check.leniency else ""),
        "Keeps from modeling": _blocks(check),
        "Waits for": WAITS[max(check.need, check.stage or check.need)],
        "Tolerance": _tolerance(check),
        "Repairable": "yes" if check.repairable else "no",
    }
    return "\n".join(["| | |", "|---|---|", *(f"| **{key}** | {text} |" for key, text in rows.items())])


def table() -> str:
    """Return the table of all checks for checks.md."""
    lines = [
        "| check | asks | paper | profile paper | profile extended | keeps from modeling |",
        "|---|---|---|---|---|---|",
    ]
    for check in CHECKS:
        paper, extended = PROFILES[check.severity]
        note = f"; {check.leniency}" if check.leniency else ""
        lines.append(
            f"| [{check.id}](checks/{check.id}.md) | {check.sentence} | {check.section} | {paper} | "
            f"{extended}{note} | {_blocks(check)} |"
        )
    return "\n".join(lines)


def repairs() -> str:
    """Return the table of all repairs for repair.md."""
    lines = ["| | repair | answers | does |", "|---|---|---|---|"]
    for number, repair in enumerate(REPAIRS, start=1):
        answers = ", ".join(f"[{check}](checks/{check}.md)" for check in repair.checks)
        does = repair.sentence.rstrip(".")
        lines.append(f"| {number} | {repair.id} | {answers} | {does[0].lower()}{does[1:]} |")
    return "\n".join(lines)


def _blocks(check: Check) -> str:
    if check.scope is Scope.NOTHING:
        return "nothing"
    return f"{check.scope.value}{f': {check.blocks_when}' if check.blocks_when else ''}"


def _tolerance(check: Check) -> str:
    t = check.tolerance
    if t is None:
        return "none"
    return f"{t.meaning}, {t.unit}; `[checks] {check.id}`, default {t.default}"


def pages() -> dict[Path, str]:
    """Return what stands between the marks of each page."""
    return {
        DOCS / "checks.md": table(),
        DOCS / "repair.md": repairs(),
        **{DOCS / "checks" / f"{check.id}.md": facts(check) for check in CHECKS},
    }


if __name__ == "__main__":
    sys.exit(write(pages()))
