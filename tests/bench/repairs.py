"""Repairs: 300 corrupted networks, and the faults of the Community Fault Model by groups and all at once."""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import time
from collections import Counter
from dataclasses import replace

from graben.finding import CheckResult, Status
from graben.repairs import repair
from tests.bench.network import model
from tests.bench.tables import DATA, Table, seconds_table
from tests.cleaning.corruption import KINDS, Case, cases, judged

COUNT = 300
GROUPS = ("SAFS-MHFZ", "SAFS-SGPR", "SAFS-SAFZ", "")


def figures() -> Table:
    table = _harness()
    if (DATA / "cfm").is_dir():
        table |= _cfm()
    else:
        print("cfm left out: ../shared/data is missing")
    return table


def _harness() -> Table:
    """Print and return the share of corrupted networks that are clean again, by kind."""
    ends = {case: _ended(case) for case in cases(COUNT)}
    for case, end in ends.items():
        if not end["passed"]:
            print(f"{case.name}: {end['why']}; {'reported' if end['reported'] else 'NOT REPORTED'}")
    rows: Table = {}
    for kind in (*KINDS, ""):
        own = [end for case, end in ends.items() if not kind or kind in case.kinds]
        rows[kind or "all"] = {
            "cases": len(own),
            "passed %": 100.0 * sum(e["passed"] for e in own) / len(own),
            "silent": sum(not e["passed"] and not e["reported"] for e in own),
            "twice is once %": 100.0 * sum(e["once"] for e in own) / len(own),
            "median s": statistics.median(e["seconds"] for e in own),
            "longest s": max(e["seconds"] for e in own),
        }
    seconds_table("corrupted networks repaired", rows)
    return {f"repaired: {name}": row for name, row in rows.items()}


def _ended(case: Case) -> dict[str, object]:
    """Return how one corrupted network ended.

    Reported: what is wrong with it is a finding of the repaired model, a note on what is left, or a change of
    the faults concerned in the ledger.
    """
    built = case.built()
    begin = time.perf_counter()
    result = repair(built.model, "paper")
    seconds = time.perf_counter() - begin
    verdict = judged(built.clean, built.model, result.model, result.actions)
    again = repair(result.model, "paper")
    said = {n for a in result.actions for n in a.objects} | {n for note in result.left for n in note.objects}
    said |= {n for f in result.after.findings if f.status is Status.FAIL for n in f.objects}
    return {
        "passed": verdict.passed,
        "why": "; ".join(f"{criterion} {names}: {text}" for criterion, names, text in verdict.failed),
        "reported": all(said.intersection(names.split(", ")) for _, names, _ in verdict.failed),
        "once": not again.actions,
        "seconds": seconds,
    }


def _cfm() -> Table:
    """Return what becomes of real faults, each group in a process of its own."""
    rows: Table = {}
    for group in GROUPS:
        command = [sys.executable, "-m", "tests.bench.repairs", group]
        rows[group or "all 142 faults"] = json.loads(subprocess.check_output(command).splitlines()[-1])
    seconds_table("CFM repaired, profile paper", rows)
    return {f"CFM repaired: {name}": row for name, row in rows.items()}


def main(group: str) -> None:
    whole = model()
    faults = replace(whole, faults=tuple(f for f in whole.faults if f.name.startswith(group)))
    result = repair(faults, "paper", lambda stage, what: print(f"{stage:<10} {what}", file=sys.stderr))
    row: dict[str, float] = {"faults": len(faults.faults), "seconds": result.seconds}
    row |= {"peak MiB": result.peak_memory_mb, "failing before": _failing(result.before)}
    row |= {"failing after": _failing(result.after), "actions": len(result.actions)}
    for check, count in sorted(_counts(result.after).items()):
        row[f"left: {check}"] = count
    for note in result.left:
        if (note.check, note.objects) in {
            (f.check, f.objects) for f in result.after.findings if f.status is Status.FAIL
        }:
            print(f"{note.check} {', '.join(note.objects)}: {note.reason}", file=sys.stderr)
    print(json.dumps(row))


def _counts(result: CheckResult) -> Counter[str]:
    return Counter(f.check for f in result.findings if f.status is Status.FAIL)


def _failing(result: CheckResult) -> int:
    return sum(_counts(result).values())


if __name__ == "__main__":
    main(sys.argv[1])
