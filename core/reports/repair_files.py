"""Everything a repair writes into its folder."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

from graben.formats.repaired import write_repaired
from graben.reports.json_report import as_text
from graben.reports.repair_html import repair_html
from graben.reports.repair_json import repair_report
from graben.reports.repair_moves import fault_changes

if TYPE_CHECKING:
    from graben.repairs import RepairResult


def write_repair(result: RepairResult, folder: Path) -> None:
    """Write model.toml with the files of its surfaces, report.json and report.html.

    Parameters
    ----------
    result : RepairResult
        A finished repair.
    folder : Path
        Where to write; made where it is missing, files of the same names are replaced.
    """
    begin = time.perf_counter()
    write_repaired(result.input, result.model, folder)
    changes = fault_changes(result)
    page = repair_html(result, changes, files=True)
    (folder / "report.html").write_text(page, encoding="utf-8", newline="\n")
    writing = time.perf_counter() - begin
    timings = {"repair": result.seconds, "write": writing, "total": result.seconds + writing}
    text = as_text(repair_report(result, changes, timings))
    (folder / "report.json").write_text(text, encoding="utf-8", newline="\n")
